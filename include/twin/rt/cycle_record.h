#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_errors.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::rt {

/// What INT did about this cycle's command.
enum class CommandFate : std::uint8_t {
  kNone = 0,    ///< no motion, or a motion that has not had its first command yet
  kServed = 1,  ///< a command answered the last state in time
  kHeld = 2,    ///< none did: the last commanded acceleration was held
};

/// One INT cycle, as the robot saw it. Trivially copyable.
struct CycleRecord {
  Time at{};             ///< INT's instant of the cycle
  RobotState state;      ///< the state this cycle sent
  JointVector dddq_d{};  ///< jerk of the reference by backward differences, rad/s^3
  CommandFate fate = CommandFate::kNone;
  std::uint32_t lost_in_row = 0;  ///< cycles held so far without a break
  std::uint32_t dropped =
      0;  ///< commands that arrived for this cycle but too late, doubled or with a wrong id
  bool violated = false;  ///< this cycle raised `violation`
  Violation violation;
  std::optional<BaseState> base{};  ///< of a robot on a mobile base: what its drives knew
};

/// What the workstation's tick did with a state.
enum class TickAction : std::uint8_t {
  kPublished =
      0,         ///< state passed on, nothing to send (no motion, or the activation gate is closed)
  kWritten = 1,  ///< a command was written
  kFinished = 2,  ///< a command asking to end the motion was written
  kSkipped = 3,   ///< the cycle was anomalous: nothing written
  kInvalid = 4,   ///< the command was not valid (not finite, no rotation), or the controller gave
                  ///< up: nothing written
};

/// One tick of the workstation, as EXT saw it. Trivially copyable.
struct TickRecord {
  std::uint64_t message_id = 0;  ///< of the state that paced the tick
  Time read{};                   ///< end of the state's read
  Time written{};  ///< end of the command's write; equals `read` when nothing was written. d_EXT =
                   ///< written - read
  TickAction action = TickAction::kPublished;
  std::uint32_t skipped_states =
      0;                ///< states that never reached EXT since the last tick (gap in message_id)
  Time deposit_time{};  ///< source time of the deposit in use
  /// Deposited target after rate matching, or where the resampler has the source now: position,
  /// rad.
  JointVector q_ext{};
  JointVector dq_ext{};  ///< its velocity, rad/s
  bool stalled =
      false;  ///< the source counts as stalled: no deposit for loop::TickConfig::stall_time
  /// Behind a viability filter (reference::ViabilityFilter): the least of the joints' margins in
  /// the state answered, and the joints whose command was changed, bit i for joint i, from 0.
  /// Absent, and none, where no command passed one.
  std::optional<double> margin{};
  std::uint8_t kept_back = 0;
  RobotCommand command;  ///< what was written; all zero when nothing was
};

/// Takes the records of a run off the tick.
///
/// Threads: each method from the one thread that produces that kind of record (lockstep: one thread
/// for both). Real-time: noexcept, no allocation; in lockstep it may wait for the writer, in
/// realtime it drops and counts.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  virtual void Put(const CycleRecord& record) noexcept TWIN_REALTIME = 0;
  virtual void Put(const TickRecord& record) noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::rt
