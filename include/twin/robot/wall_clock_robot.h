#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "twin/robot/threaded_robot.h"
#include "twin/rt/duration_histogram.h"

namespace twin::robot {

/// An emulated robot on the wall clock. INT, plant and link are those of lockstep; delays of the
/// link pass in real time.
///
///     workstation                       the robot's thread: sleep until the next event is due
///     commands ---> WorkstationPort ---> CommandLink ---> INT, plant
///     states   <--- WorkstationPort <--- StateLink   <-----+
///
/// Events run in the order of their times: a command enters the link at its arrival time, after all
/// events due earlier. When the host stopped the thread, the robot makes up for cycles of at most
/// RobotConfig::catch_up less those just lost, one right after the other. No command arrives in
/// them, and INT holds the acceleration, as if only the workstation had stopped. The robot sends
/// the last of their states only. A cycle later than that by more than 0.25 ms is postponed with
/// all later ones; skipped whole periods are counted. On a shared thread, where a cycle may wait
/// for those of other robots, so are those after a cycle that took longer than that: the robots'
/// cycles stay together.
///
/// Threads: as ThreadedRobot; statistics from the thread that calls End(). Real-time: the robot's
/// thread allocates and locks nothing between Begin() and End().
class WallClockRobot : public ThreadedRobot {
 public:
  /// As ThreadedRobot. @throws InputError as Robot.
  WallClockRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                 WorkstationPort& port, const MonotonicClock& clock, rt::ThreadSettings thread,
                 record::RecordSink* sink);
  ~WallClockRobot() override { End(); }

  /// Lateness of a cycle's start, including the periods by which it was postponed.
  /// @pre for this and the following: not between Begin() and End().
  [[nodiscard]] const rt::DurationHistogram& lateness() const noexcept { return lateness_; }
  /// Number of whole periods skipped.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

 private:
  void OnEvent(Time now, std::uint64_t message_id) noexcept final;
  void Run(const std::stop_token& stop) noexcept final;
  void WorkOff(Time now) noexcept TWIN_REALTIME;
  void RunEventsUntil(Time until) noexcept TWIN_REALTIME;
  /// Lateness up to which the robot makes up for cycles: catch_up less the commands just lost.
  [[nodiscard]] Duration AllowedLateness() noexcept TWIN_REALTIME;
  void PostponeIfStalled(Time now) noexcept TWIN_REALTIME;
  /// Unless it is little.
  void PostponeBy(Duration late) noexcept TWIN_REALTIME;

  const Duration catch_up_;
  ReceivedCommand received_;
  rt::DurationHistogram lateness_;
  std::uint64_t overruns_ = 0;
  Duration postponed_{};  ///< of the next cycle, so far
};

}  // namespace twin::robot
