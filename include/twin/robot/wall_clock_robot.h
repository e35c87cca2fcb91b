#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "twin/robot/threaded_robot.h"
#include "twin/rt/duration_histogram.h"

namespace twin::robot {

/// A whole emulated robot on the wall clock. INT, plant and link are those of lockstep; a delay of
/// the link is really waited for.
///
///     workstation                       the robot's thread: sleep until the next event is due
///     commands ---> WorkstationPort ---> CommandLink ---> INT, plant
///     states   <--- WorkstationPort <--- StateLink   <-----+
///
/// What is due runs in order of its time: a command enters the link at the instant it came, after
/// all that was due before. A cycle that would begin more than 0.25 ms late is postponed by as
/// much, and all after it: two cycles are never much closer than a period, nothing is caught up,
/// and the whole periods among it are counted.
///
/// Threads: as ThreadedRobot; the figures from the thread that calls End(). Real-time: the robot's
/// thread allocates and locks nothing between Begin() and End().
class WallClockRobot : public ThreadedRobot {
 public:
  /// As ThreadedRobot. @throws InputError as Robot.
  WallClockRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                 WorkstationPort& port, const MonotonicClock& clock, rt::ThreadSettings thread,
                 rt::RecordSink* sink);
  ~WallClockRobot() override { End(); }

  /// Begin of a cycle after its deadline, in which periods it was postponed by are contained.
  /// @pre this and the following: not between Begin() and End().
  [[nodiscard]] const rt::DurationHistogram& lateness() const noexcept { return lateness_; }
  /// Whole periods that were skipped.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

 private:
  void OnEvent(Time now, std::uint64_t message_id) noexcept final;
  void Run(const std::stop_token& stop) noexcept final;
  void WorkOff(Time now) noexcept TWIN_REALTIME;
  void RunEventsUntil(Time until) noexcept TWIN_REALTIME;
  void PostponeIfStalled(Time now) noexcept TWIN_REALTIME;

  ReceivedCommand received_;
  rt::DurationHistogram lateness_;
  std::uint64_t overruns_ = 0;
  Duration postponed_{};  ///< the next cycle, so far
};

}  // namespace twin::robot
