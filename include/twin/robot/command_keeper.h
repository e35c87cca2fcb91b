#pragma once

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/reference/pose_viability_filter.h"
#include "twin/reference/viability_filter.h"

namespace twin::robot {

/// Replaces each command of a running motion by the nearest one that keeps the limits at all times,
/// even if up to n consecutive commands are lost. A client library could do this for its users;
/// here the robot does it, to test the benefit for an unmodified program. A real robot has no such
/// filter.
///
/// Joint positions and velocities go through reference::ViabilityFilter, poses and twists through
/// reference::PoseViabilityFilter; elbow and torques pass unchanged. So does a motion's first
/// command, which must start at the robot's reference and which INT rejects otherwise.
///
/// Threads: the robot's. Real-time: noexcept, allocates nothing.
class CommandKeeper {
 public:
  /// @param lost  n. @throws InputError as both filters.
  CommandKeeper(const JointLimits& joints, const CartesianLimits& cartesian, int lost);

  /// @param answered  the robot's last state, which the command answers.
  [[nodiscard]] RobotCommand Keep(const RobotState& answered,
                                  const RobotCommand& command) const noexcept TWIN_REALTIME;

 private:
  reference::ViabilityFilter joints_;
  reference::PoseViabilityFilter poses_;
};

}  // namespace twin::robot
