#pragma once

#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// The workstation's threads in real time.
struct RealtimeThreads {
  /// Reads states and writes commands; nothing else runs on it (but the controller, in the inline
  /// loops).
  rt::ThreadSettings communication{.name = "twin-ext", .fifo_priority = 99};
  /// Runs the controller of the asynchronous loop; whatever it costs, the other is not held up.
  rt::ThreadSettings controller{.name = "twin-control"};
};

/// The time of a simulated robot on the wall clock: its cycles go on from construction to End(),
/// over as many motions as are run meanwhile. Of a robot that keeps its own time: nothing.
///
/// Threads: one.
class RobotCycles {
 public:
  /// @param connection  of a RealtimeHost or RemoteHost; must outlive this. Once per connection.
  /// @throws as backend::RealtimeRobotControl::Begin.
  explicit RobotCycles(const backend::Connection& connection);
  ~RobotCycles();
  RobotCycles(const RobotCycles&) = delete;
  RobotCycles& operator=(const RobotCycles&) = delete;

  /// No record is put and no state sent after it returns. May be called again.
  /// @returns how the robot kept its time.
  backend::RobotTimings End();

 private:
  backend::RealtimeRobotControl* robot_;  ///< null: it keeps its own time
};

/// Runs a motion from start to end on the wall clock: the communication loop on a thread of its
/// own, the controller of the asynchronous loop on another, the calling thread looks on.
///
///     robot's thread --state--> [Arrival] communication thread --command--> robot's thread
///                                   |  ^
///                            states v  | deposits   (two LatestValues; neither side waits)
///                                 controller thread
///
/// The communication thread stops the motion itself when it fails (invalid command, connection
/// gone, an exception), before anything is said about it; the report then carries the last ticks.
/// What overruns is counted and skipped, never caught up in bursts.
///
/// @param clock       the run's time line.
/// @param connection  of a RealtimeHost with the same clock, while its RobotCycles go on; or of a
///                    RemoteHost.
/// @param run         run.backend is connection.backend. Delay models of tick and controller do not
///                    count: what things cost is what passes.
/// @throws as LockstepDrive::Run; EnvironmentError when a thread cannot be set up as asked for.
[[nodiscard]] RunReport RunInRealtime(const MonotonicClock& clock,
                                      const backend::Connection& connection, const MotionRun& run,
                                      const RealtimeThreads& threads = {});

}  // namespace twin::loop
