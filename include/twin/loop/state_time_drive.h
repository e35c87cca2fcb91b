#pragma once

#include <cstdint>

#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"

namespace twin::loop {

/// The time of a robot whose time is its states, over several motions.
struct StateTimeline {
  std::uint64_t first_id = 0;  ///< of the state at time zero; 0: of the next that is read
  Time now{};                  ///< of the state read last
};

/// Runs a motion from start to end with a robot whose time is its states (RobotTime::kStates): a
/// twin that is served in lockstep. One thread, the caller's, reads, computes and writes; it waits
/// for states as long as the robot does for commands, and no time passes meanwhile.
///
/// All times of the run (ticks, limit, progress) are the robot's, counted from the first state
/// read, or as the timeline has it. What starts at a given state goes on alike whatever the machine
/// does: the same motion gives the same commands, and the same log but for how many states came
/// before it.
///
/// @param clock       of the host: for looking at the caller's wishes while no state comes.
/// @param connection  of a RemoteHost.
/// @param run         run.backend is connection.backend; asynchronous or bare. Delay models do not
///                    count; every state of the motion is answered, whatever period_tolerance says:
///                    the robot would wait for the answer.
/// @param timeline    goes on in this run; null: the run has one of its own.
/// @throws InputError for the synchronous loop, which sleeps on a clock of its own; as
/// LockstepDrive::Run.
[[nodiscard]] RunReport RunOnStateTime(const MonotonicClock& clock,
                                       const backend::Connection& connection, const MotionRun& run,
                                       StateTimeline* timeline = nullptr);

}  // namespace twin::loop
