#pragma once

#include <optional>

#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// The scenario's trajectory, checked against the robot's limits; of a motion of poses, the arm at
/// rest where it begins for as long as they take. @throws InputError as Trajectory and
/// PoseTrajectory, and for a motion that is planned: that takes a Run.
[[nodiscard]] reference::Trajectory MakeTrajectory(const scenario::Scenario& scenario,
                                                   const scenario::RobotData& robot);

/// The path of a motion of poses, checked against the robot's limits; nothing for others.
/// @throws InputError as PoseTrajectory.
[[nodiscard]] std::optional<reference::PoseTrajectory> MakePoses(const scenario::Scenario& scenario,
                                                                 const scenario::RobotData& robot);

}  // namespace twin::run
