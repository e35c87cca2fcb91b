#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/command_chain.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/record/cycle_record.h"

namespace twin::loop {

/// The workstation's 1 kHz step, one function of a robot state: publish it, fetch the newest
/// deposit, match rates, generate the reference, give the command that answers the state. No clock,
/// no thread, no allocation: the asynchronous thread, a synchronous loop and the lockstep drive
/// call the same object.
///
/// The activation gate: nothing is transmitted until this side has read a state of the running
/// motion *and* the controller has deposited a target made from such a state. A deposit left over
/// from before can therefore never move the arm.
///
/// Anomalous cycles: with P the time between the last two reads, |P - 1 ms| > period_tolerance
/// means that this side no longer knows where the robot's cycle is. Nothing is written; the robot
/// holds its acceleration (or torque) and the last consistent target stays. Source of both rules:
/// the paper's section on the asynchronous thread.
///
/// A command that is not valid (a controller gave NaN) is never sent, nor one of a controller that
/// gave up; the record says kInvalid, and the drive stops the motion.
///
/// Finish: once a deposit says finished, its (matched) target is at rest and the robot's reference
/// has come within the finish tolerance of it, the commands carry motion_generation_finished until
/// the motion ends.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class ControlTick {
 public:
  /// @throws InputError as TickConfig::Validate.
  ControlTick(const TickConfig& config, control::CommandInterface interface, Exchange& exchange);

  /// A motion with these modes is about to start: closes the gate and forgets the last motion.
  void Activate(const MotionModes& modes) noexcept;

  /// Publish() and Answer() in one.
  /// @param state    the newest state. @param read  when its read ended.
  /// @returns the command to write, or null when nothing is to be sent; valid until the next call.
  [[nodiscard]] const RobotCommand* Tick(const RobotState& state, Time read) noexcept TWIN_REALTIME;

  /// First half: shows the state to the controller side.
  void Publish(const RobotState& state, Time read) noexcept TWIN_REALTIME;
  /// Second half: the command that answers the state published last. @param state  that state.
  [[nodiscard]] const RobotCommand* Answer(const RobotState& state) noexcept TWIN_REALTIME;

  /// What the last tick did; the caller fills in `written`.
  [[nodiscard]] record::TickRecord& record() noexcept { return record_; }

  /// Target of the last command generated, rate-matched.
  [[nodiscard]] const reference::Target& target() const noexcept { return chain_.matched(); }
  [[nodiscard]] control::CommandInterface interface() const noexcept { return interface_; }

  /// Whether the state belongs to the running motion: robot_mode Move and both modes as started.
  [[nodiscard]] bool InMotion(const RobotState& state) const noexcept;

 private:
  [[nodiscard]] bool IsAnomalous(Time read) const noexcept;
  [[nodiscard]] bool PassesGate(const RobotState& state) noexcept;
  void Generate(const RobotState& state) noexcept;

  control::CommandInterface interface_;
  Duration period_tolerance_;
  Exchange& exchange_;
  CommandChain chain_;

  MotionModes modes_;
  std::uint64_t first_id_ = 0;  ///< of the motion; 0 before its first state
  bool open_ = false;
  bool finishing_ = false;
  bool anomalous_ = false;
  std::uint64_t cycles_ = 0;  ///< of the robot since the last command was generated
  bool fresh_ = false;        ///< a deposit has come since then
  record::TickRecord record_;
};

}  // namespace twin::loop
