#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/core/time.h"

namespace twin::backend {

/// Which of the queued states a read takes.
enum class ReadRule : std::uint8_t {
  /// What is queued counts: the newest unread state, even if it has waited.
  kNewest,
  /// What is queued when the reader comes is thrown away: a state counts only if it arrived after a
  /// Read() that gave kPending. (In lockstep, where a reader is called at the instant of an arrival
  /// because it waits, also one that arrives now.)
  kFresh,
};

/// Outcome of a read.
enum class ReadResult : std::uint8_t {
  kState,    ///< a state was read
  kPending,  ///< none yet; only the drive may wait
  kLost,     ///< the connection is gone
};

/// How a motion ended.
enum class MotionEnd : std::uint8_t {
  kNone,         ///< none has ended yet
  kSuccess,      ///< the finished command was accepted
  kPreempted,    ///< stopped by Stop()
  kAborted,      ///< stopped by an error
  kUserStopped,  ///< somebody pressed the user stop
};

/// What a backend is, and how its last motion ended.
struct Description {
  std::string name;   ///< "mujoco", ...
  std::string robot;  ///< one line for people: which robot, which plant
  MotionEnd last_end = MotionEnd::kNone;
  RobotErrors last_errors;            ///< errors that ended the last motion
  std::vector<Violation> violations;  ///< their details, where the backend knows them
};

/// The only seam to the arm. Speaks the vocabulary of the Franka Control Interface, whatever is
/// behind it.
///
/// Life of a motion: Start -> Read until the state shows the modes and robot_mode Move -> one more
/// Read -> from then on one Write per Read -> a command with motion_generation_finished, repeated
/// until the state is idle again. A motion that fails shows in the state: robot_mode leaves Move,
/// reflex_reason says why. Then Recover, once the arm is at rest.
///
/// Threads: Read and Write from one thread (the tick's); the others from any thread, where the
/// drive has several. Real-time: Read and Write are noexcept and allocate nothing after the first
/// Start; the others may do both.
class Backend {
 public:
  virtual ~Backend() = default;

  [[nodiscard]] virtual Description Describe() const = 0;

  /// @throws RobotFault when refused (a motion runs, or Reflex), InputError when a value is out of
  /// range, naming it.
  virtual void Configure(const Setting& setting) = 0;

  /// Asks for a motion. @throws RobotFault when refused, with the robot's mode.
  virtual void Start(const MotionModes& modes) = 0;

  /// Never waits; the one loop around it, for both rules, is
  ///   while (Read(rule, state, arrival) == kPending) wait for an arrival, or until a deadline.
  /// @param state  written only for kState. @param arrival  when it arrived at this side: in
  /// lockstep to the instant, in real time when the reader has it, which is what its d_EXT counts
  /// from.
  [[nodiscard]] virtual ReadResult Read(ReadRule rule, RobotState& state,
                                        Time& arrival) noexcept TWIN_REALTIME = 0;

  /// Sends a command; it answers the state named in its message_id. A command that cannot be sent
  /// is lost, as on the wire.
  virtual void Write(const RobotCommand& command) noexcept TWIN_REALTIME = 0;

  /// Asks to end a running motion at once: the robot decelerates within its limits. No motion: no
  /// effect.
  virtual void Stop() = 0;

  /// Automatic error recovery. @throws RobotFault when refused (the arm still moves, or the state
  /// does not allow it).
  virtual void Recover() = 0;
};

}  // namespace twin::backend
