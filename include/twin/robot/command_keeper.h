#pragma once

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/reference/pose_viability_filter.h"
#include "twin/reference/viability_filter.h"

namespace twin::robot {

/// What a client library could do for any program of its users, done at the robot's door: makes of
/// each command of a motion that runs the nearest one that keeps the limits for ever, whatever up
/// to n commands in a row are lost. For trying out what that is worth to a program as it is; a real
/// robot has no such thing.
///
/// Joint positions and velocities go through reference::ViabilityFilter, poses and twists through
/// reference::PoseViabilityFilter; elbow and torques pass. A motion's first command passes too: it
/// must begin where the robot is, and INT says so when it does not.
///
/// Threads: the robot's. Real-time: noexcept, allocates nothing.
class CommandKeeper {
 public:
  /// @param lost  n. @throws InputError as both filters.
  CommandKeeper(const JointLimits& joints, const CartesianLimits& cartesian, int lost);

  /// @param answered  state that the command answers: the robot's last one.
  [[nodiscard]] RobotCommand Keep(const RobotState& answered,
                                  const RobotCommand& command) const noexcept TWIN_REALTIME;

 private:
  reference::ViabilityFilter joints_;
  reference::PoseViabilityFilter poses_;
};

}  // namespace twin::robot
