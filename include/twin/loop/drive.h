#pragma once

#include <functional>
#include <memory>
#include <string>

#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"
#include "twin/record/cycle_record.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// Advances time for a connected robot, and runs motions in it.
///
///     Begin() -> { Run() | PassUntil() } ... -> End()
///
/// - Lockstep: an event queue on a virtual clock, one thread. Inputs and seed determine the
/// records.
///   Time stands still between two calls.
/// - Realtime: the wall clock. The communication loop and the controller have threads of their own.
///   A simulated robot has one too, whose cycles run from Begin() to End(); a robot at the other
///   end of a wire keeps its own time.
/// - State time: a robot that is served in lockstep. Each of its states is 1 ms.
///
/// Threads: one, the caller's.
class Drive {
 public:
  virtual ~Drive() = default;
  Drive() = default;
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;

  [[nodiscard]] virtual const backend::Connection& connection() const noexcept = 0;
  /// The wall clock of realtime and state time; null in lockstep.
  [[nodiscard]] virtual const MonotonicClock* wall_clock() const noexcept { return nullptr; }

  /// Starts the time, once.
  virtual void Begin() {}

  /// Runs a motion from start to end; `run.backend` is the connection's.
  /// @throws InputError from the controller's activation, or for a loop that the drive has not;
  /// RobotFault when the robot refuses the motion; EnvironmentError when a thread cannot be set up.
  /// A motion that starts and then fails throws nothing: the report says how it ended.
  [[nodiscard]] virtual RunReport Run(const MotionRun& run) = 0;

  /// Stops the time: the sink gets no record after it returns. May be called again.
  virtual backend::RobotTimings End() { return {}; }

  /// Time since Begin().
  [[nodiscard]] virtual Time Now() const = 0;

  /// Lets time pass without a motion, and reads the states that come.
  /// @param done  asked often; its argument is the state read since the last call, or null.
  /// @returns false when `limit` came first. @throws RobotFault when the connection is gone, or no
  /// state comes for 1 s.
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool(const RobotState*)>& done);

 private:
  /// Waits until a state may have come, at most until `limit`.
  virtual void Wait(Time limit) = 0;
  /// PassUntil() has read a state.
  virtual void Observe(const RobotState& /*state*/) {}

  RobotState state_;
};

/// The threads of realtime.
struct DriveThreads {
  /// The simulated robot's.
  rt::ThreadSettings robot{.name = "twin-int", .fifo_priority = 98};
  /// Reads states and writes commands; with the inline loops it also runs the controller.
  rt::ThreadSettings communication{.name = "twin-ext", .fifo_priority = 99};
  /// Runs the controller of the asynchronous loop.
  rt::ThreadSettings controller{.name = "twin-control"};
};

/// @param connect  makes the backend, from `robot`. @param sink  gets the records of cycles and
/// ticks; may be null; must outlive the drive. In lockstep all records come from the calling
/// thread; in real time cycles come from the robot's thread, ticks from the communication's.
/// @throws as `connect`.
[[nodiscard]] std::unique_ptr<Drive> MakeLockstepDrive(const backend::Factory& connect,
                                                       const robot::RobotConfig& robot,
                                                       record::RecordSink* sink);
[[nodiscard]] std::unique_ptr<Drive> MakeRealtimeDrive(const backend::Factory& connect,
                                                       const robot::RobotConfig& robot,
                                                       record::RecordSink* sink,
                                                       const DriveThreads& threads);
/// Realtime or state time, as `address.time` says. The sink also gets the states that are read.
[[nodiscard]] std::unique_ptr<Drive> MakeRemoteDrive(const backend::Factory& connect,
                                                     const robot::RobotConfig& robot,
                                                     record::RecordSink* sink,
                                                     const backend::RobotAddress& address,
                                                     const DriveThreads& threads);

/// As MakeRemoteDrive, of a robot whose states are its time. One thread, the caller's, reads,
/// computes and writes; it waits for states as long as the robot waits for commands, and no time
/// passes meanwhile. A motion that starts at a given state repeats, whatever the machine does: it
/// gives the same commands, and the same log except for how many states came before it.
///
/// Run() refuses the synchronous loop with an InputError: it sleeps on a clock of its own. Every
/// state is answered, whatever TickConfig::period_tolerance says: the robot would wait otherwise.
[[nodiscard]] std::unique_ptr<Drive> MakeStateTimeDrive(const backend::Factory& connect,
                                                        const robot::RobotConfig& robot,
                                                        record::RecordSink* sink,
                                                        const backend::RobotAddress& address);

}  // namespace twin::loop
