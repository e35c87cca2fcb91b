#pragma once

#include <memory>
#include <utility>

#include "twin/robot/in_process_port.h"
#include "twin/robot/wall_clock_robot.h"

namespace twin::robot {

/// The emulated robot on the wall clock with its workstation in the same process: both ends of the
/// link in one object.
///
/// Threads and real-time: as InProcessPort and WallClockRobot.
class RealtimeRobot final : public InProcessPort, public WallClockRobot {
 public:
  /// @param clock   of the run; must outlive the robot.
  /// @param thread  setup of the robot's thread.
  /// @param plant, sink  as in Robot; the robot's thread puts sink's cycle records.
  /// @throws InputError as Robot.
  RealtimeRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                const MonotonicClock& clock, rt::ThreadSettings thread, rt::RecordSink* sink)
      : InProcessPort(clock),
        WallClockRobot(config, std::move(plant), *this, clock, std::move(thread), sink) {}
  /// Ends the thread before any member is destroyed.
  ~RealtimeRobot() override { End(); }
};

}  // namespace twin::robot
