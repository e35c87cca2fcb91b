#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/joint_reference_generator.h"
#include "twin/reference/rate_matcher.h"
#include "twin/rt/cycle_record.h"

namespace twin::loop {

/// The workstation's 1 kHz step, one function of a robot state: publish it, fetch the newest
/// deposit, match rates, generate the reference, give the command that answers the state. No clock,
/// no thread, no allocation: the asynchronous thread, a synchronous loop and the lockstep drive
/// call the same object.
///
/// The activation gate: nothing is transmitted until this side has read a state of the running
/// motion *and* the controller has deposited a target made from such a state. A deposit left over
/// from before can therefore never move the arm. Source: the paper's section on the asynchronous
/// thread.
///
/// The rate matcher's window is of INT's cycles: for every state that was lost on the way (a gap in
/// message_id) it takes one more step, so that a slow source keeps its pace over losses.
///
/// Finish: once a deposit says finished, its (matched) target is at rest and q_d has come within
/// finish_tolerance_rad of it, the commands carry motion_generation_finished until the motion ends.
///
/// Threads: one. Real-time: Tick() is noexcept and allocates nothing.
class ControlTick {
 public:
  /// @throws InputError as TickConfig::Validate.
  ControlTick(const TickConfig& config, control::CommandInterface interface, Exchange& exchange);

  /// A motion with these modes is about to start: closes the gate and forgets the last motion.
  void Activate(const MotionModes& modes) noexcept;

  /// @param state    the newest state. @param read  when its read ended.
  /// @returns the command to write, or null when nothing is to be sent; valid until the next call.
  [[nodiscard]] const RobotCommand* Tick(const RobotState& state, Time read) noexcept TWIN_REALTIME;

  /// What the last Tick() did; the caller fills in `written`.
  [[nodiscard]] rt::TickRecord& record() noexcept { return record_; }

  /// Whether the state belongs to the running motion: robot_mode Move and both modes as started.
  [[nodiscard]] bool InMotion(const RobotState& state) const noexcept;

 private:
  [[nodiscard]] bool PassesGate(const RobotState& state) noexcept;
  void Generate(const RobotState& state) noexcept;
  [[nodiscard]] bool Arrived(const RobotState& state) const noexcept;

  TickConfig config_;
  control::CommandInterface interface_;
  Exchange& exchange_;
  reference::RateMatcher matcher_;
  reference::JointReferenceGenerator generator_;

  MotionModes modes_;
  std::uint64_t first_id_ = 0;  ///< of the motion; 0 before its first state
  bool open_ = false;
  bool finishing_ = false;
  reference::JointTarget matched_;
  rt::TickRecord record_;
};

}  // namespace twin::loop
