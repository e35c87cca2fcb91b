#pragma once

#include <cstdint>
#include <optional>

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

/// The workstation's 1 kHz step: publishes a robot state, fetches the newest deposit, matches
/// rates, generates the reference and returns the command that answers the state. It uses no clock
/// and no thread: asynchronous thread, synchronous loop and lockstep drive call the same object.
///
/// Activation gate: the tick transmits nothing until this side has read a state of the running
/// motion *and* the controller has deposited a target made from such a state. A deposit from an
/// earlier motion therefore never moves the arm.
///
/// Anomalous cycles: with P the time between the last two reads, |P - 1 ms| > period_tolerance
/// means that this side has lost the phase of the robot's cycle. The tick writes nothing; the robot
/// holds its acceleration (or torque), and the last consistent target stays. Source of both rules:
/// the paper's section on the asynchronous thread.
///
/// Invalid commands (NaN from a controller) and commands of a controller that has given up are not
/// sent; the record says kInvalid, and the drive stops the motion.
///
/// Limits of a lab (TickConfig::lab): from the tick at which a command would break one, the tick
/// writes the commands of the stop, or none where the robot itself must stop the arm; the record
/// says kLimited. The drive ends the motion once stopped_by_limit().
///
/// Finish: a command carries motion_generation_finished if its deposit is marked finished and
/// CommandChain::Finish() holds in the answered state. Each command is judged anew, because the
/// robot keeps its last acceleration while commands are lost and may no longer be at rest. A source
/// that has finished and still moves, by noise, counts as at rest after 100 commands while it moves
/// less than the tolerance per cycle.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class ControlTick {
 public:
  /// @throws InputError as TickConfig::Validate().
  ControlTick(const TickConfig& config, control::CommandInterface interface, Exchange& exchange);

  /// Prepares a motion with these modes: closes the gate and discards the last motion's data.
  void Activate(const MotionModes& modes) noexcept;

  /// Publish() and Answer() in one.
  /// @param state    the newest state. @param read  end of its read.
  /// @returns the command to write, or null to send nothing; valid until the next call.
  [[nodiscard]] const RobotCommand* Tick(const RobotState& state, Time read) noexcept TWIN_REALTIME;

  /// First half: publishes the state to the controller side.
  void Publish(const RobotState& state, Time read) noexcept TWIN_REALTIME;
  /// Second half: computes the answer. @param state  the state published last.
  [[nodiscard]] const RobotCommand* Answer(const RobotState& state) noexcept TWIN_REALTIME;

  /// Record of the last tick; the caller fills in `written`.
  [[nodiscard]] record::TickRecord& record() noexcept { return record_; }

  /// Rate-matched target of the last generated command.
  [[nodiscard]] const reference::Target& target() const noexcept { return chain_.matched(); }
  /// The limit for which this motion was stopped; nullopt: none. Constant once stopped_by_limit().
  [[nodiscard]] std::optional<onboard::BrokenLimit> breach() const noexcept {
    return open_ ? chain_.breach() : std::nullopt;
  }
  [[nodiscard]] bool stopped_by_limit() const noexcept { return open_ && chain_.stopped(); }
  [[nodiscard]] control::CommandInterface interface() const noexcept { return interface_; }

  /// True when the state belongs to the running motion: robot_mode Move and both modes as started.
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
  std::uint64_t first_id_ = 0;  ///< message_id of the motion's first state; 0 before
  bool open_ = false;
  std::uint64_t finished_for_ = 0;  ///< commands since the deposits are marked finished
  bool anomalous_ = false;
  std::uint64_t cycles_ = 0;  ///< robot cycles since the last generated command
  bool fresh_ = false;        ///< a deposit has arrived since then
  record::TickRecord record_;
};

}  // namespace twin::loop
