#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/core/time.h"

namespace twin::backend {

/// Selects which queued state a read returns.
enum class ReadRule : std::uint8_t {
  /// The newest unread state, including one that was queued before the call.
  kNewest,
  /// Discards the states that are already queued. Returns only a state that arrives after a Read()
  /// that gave kPending. (Lockstep calls a waiting reader at the instant of an arrival; that state
  /// counts too.)
  kFresh,
};

/// Outcome of a read.
enum class ReadResult : std::uint8_t {
  kState,    ///< a state was read
  kPending,  ///< no state yet; only the drive may wait
  kLost,     ///< the connection is gone
};

/// How a motion ended.
enum class MotionEnd : std::uint8_t {
  kNone,         ///< none has ended yet
  kSuccess,      ///< the finished command was accepted
  kPreempted,    ///< stopped by Stop()
  kAborted,      ///< stopped by an error
  kUserStopped,  ///< stopped by the user stop
};

/// "none", "success", "preempted", "aborted", "user_stopped".
[[nodiscard]] constexpr std::string_view NameOf(MotionEnd end) noexcept {
  switch (end) {
    case MotionEnd::kNone: return "none";
    case MotionEnd::kSuccess: return "success";
    case MotionEnd::kPreempted: return "preempted";
    case MotionEnd::kAborted: return "aborted";
    case MotionEnd::kUserStopped: return "user_stopped";
  }
  return "";
}

/// Identity of a backend, and the end of its last motion.
struct Description {
  std::string name;   ///< "mujoco", ...
  std::string robot;  ///< one line for users: robot and plant
  MotionEnd last_end = MotionEnd::kNone;
  RobotErrors last_errors;            ///< errors that ended the last motion
  std::vector<Violation> violations;  ///< details of the errors, if the backend knows them
};

/// The only seam to the arm. Uses the vocabulary of the Franka Control Interface for every robot.
///
/// Life of a motion: Start -> Read until the state shows the modes and robot_mode Move -> one more
/// Read -> from then on one Write per Read -> a command with motion_generation_finished, repeated
/// until the state is idle again. The state shows a failed motion: robot_mode leaves Move and
/// reflex_reason gives the cause. Call Recover once the arm is at rest.
///
/// Threads: Read and Write from one thread (the tick's); the others from any thread, if the drive
/// has several. Real-time: Read and Write are noexcept and do not allocate after the first Start;
/// the other functions may allocate and throw.
class Backend {
 public:
  virtual ~Backend() = default;

  [[nodiscard]] virtual Description Describe() const = 0;

  /// @throws RobotFault if refused (a motion runs, or Reflex); InputError naming a value out of
  /// range.
  virtual void Configure(const Setting& setting) = 0;

  /// Requests a motion. @throws RobotFault if refused, with the robot's mode.
  virtual void Start(const MotionModes& modes) = 0;

  /// Never waits. Both rules use the same loop:
  ///   while (Read(rule, state, arrival) == kPending) wait for an arrival, or until a deadline.
  /// @param state  written only for kState. @param arrival  arrival time at this side: exact in
  /// lockstep; in real time the instant at which the reader has the state, where its d_EXT begins.
  [[nodiscard]] virtual ReadResult Read(ReadRule rule, RobotState& state,
                                        Time& arrival) noexcept TWIN_REALTIME = 0;

  /// Sends the command that answers the state with its message_id. A command that cannot be sent is
  /// lost, as on the wire.
  virtual void Write(const RobotCommand& command) noexcept TWIN_REALTIME = 0;

  /// Ends a running motion at once: the robot decelerates within its limits. No effect without a
  /// motion.
  virtual void Stop() = 0;

  /// Automatic error recovery. @throws RobotFault if refused (the arm still moves, or the state
  /// does not allow recovery).
  virtual void Recover() = 0;
};

}  // namespace twin::backend
