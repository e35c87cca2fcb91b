#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_errors.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::record {

/// What INT did with the command of a cycle.
enum class CommandFate : std::uint8_t {
  kNone = 0,    ///< no motion, or before its first command
  kServed = 1,  ///< a command answered the last state in time
  kHeld = 2,    ///< no command: the last commanded acceleration was held
};

/// One INT cycle as seen by the robot. Trivially copyable.
struct CycleRecord {
  Time at{};             ///< start of the cycle on INT's clock
  RobotState state;      ///< sent in this cycle
  JointVector dddq_d{};  ///< jerk of the reference by backward differences, rad/s^3
  CommandFate fate = CommandFate::kNone;
  std::uint32_t lost_in_row = 0;  ///< consecutive held cycles so far
  std::uint32_t dropped =
      0;  ///< commands that arrived for this cycle but too late, doubled or with a wrong id
  bool violated = false;  ///< this cycle raised `violation`
  Violation violation;
  std::optional<BaseState> base{};  ///< of a mobile base, as known to its drives
};

/// What the workstation's tick did with a state.
enum class TickAction : std::uint8_t {
  kPublished =
      0,         ///< state passed on, nothing to send (no motion, or the activation gate is closed)
  kWritten = 1,  ///< a command was written
  kFinished = 2,  ///< a command that ends the motion was written
  kSkipped = 3,   ///< anomalous cycle: nothing written
  kInvalid = 4,   ///< invalid command (not finite, not a rotation), or the controller gave up:
                  ///< nothing written
  kLimited = 5,   ///< stopped before a limit of the lab: the command of the stop was written, or
                  ///< none where the robot itself stops the arm
};

/// One tick of the workstation as seen by EXT. Trivially copyable.
struct TickRecord {
  std::uint64_t message_id = 0;  ///< of the state that paced the tick
  Time read{};                   ///< end of the state's read
  Time written{};  ///< end of the command's write; equals `read` if nothing was written. d_EXT =
                   ///< written - read
  TickAction action = TickAction::kPublished;
  std::uint32_t skipped_states =
      0;                ///< states that never reached EXT since the last tick (gap in message_id)
  Time deposit_time{};  ///< source time of the current deposit
  /// Deposited target after rate matching, or the source's present position in a resampler, rad.
  JointVector q_ext{};
  JointVector dq_ext{};  ///< its velocity, rad/s
  bool stalled =
      false;  ///< the source counts as stalled: no deposit for loop::TickConfig::stall_time
  /// Behind a viability filter (reference::ViabilityFilter): the smallest joint margin in the
  /// answered state, and a bit i per joint i (from 0) whose command was changed. Absent, and none,
  /// without a filtered command.
  std::optional<double> margin{};
  std::uint8_t kept_back = 0;
  RobotCommand command;  ///< as written; of kInvalid the one refused; else all zero
};

/// Whether the tick wrote a command of its command chain; not that of a stop before a lab's limit.
[[nodiscard]] constexpr bool WroteCommand(const TickRecord& tick) noexcept {
  return tick.action == TickAction::kWritten || tick.action == TickAction::kFinished;
}

/// Receives the records of a run off the tick.
///
/// Threads: each method from the one thread that produces its records (lockstep: one for both).
/// Real-time: noexcept, no allocation; in lockstep it may wait for the writer, in realtime it drops
/// and counts.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  virtual void Put(const CycleRecord& record) noexcept TWIN_REALTIME = 0;
  virtual void Put(const TickRecord& record) noexcept TWIN_REALTIME = 0;
};

/// Statistics of a viability filter over a run.
struct FilterCounts {
  /// Closest approach of the reference to the border of the viable set.
  struct Nearest {
    double margin = 0;  ///< as TickRecord::margin
    Time at{};          ///< time of the state's read
  };

  std::uint64_t commands = 0;                     ///< that passed the filter
  std::uint64_t kept_back = 0;                    ///< of those, changed in at least one joint
  std::array<std::uint64_t, kJoints> of_joint{};  ///< changed for this joint
  std::optional<Nearest> nearest{};               ///< absent without filtered commands

  /// Share of changed commands, %; 0 without commands.
  [[nodiscard]] double kept_back_percent() const noexcept;

  /// Adds a tick; ticks without a written or filtered command do not count. Real-time: noexcept,
  /// allocates nothing.
  void Add(const TickRecord& tick) noexcept TWIN_REALTIME;
};

}  // namespace twin::record
