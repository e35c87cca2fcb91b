#pragma once

#include "twin/planning/planner.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Plans the scenario's motion. The same scenario, robot and start give the same one to the bit,
/// whatever the seed of the plant's options. A random goal is drawn as from robot.q_start.
/// @param start       where the arm stands, rad.
/// @param world       what stands around the robot, on what shapes.
/// @param statistics  filled in.
/// @pre scenario.motion.plan and scenario.robot.q_start are there.
/// @throws InputError when start or goal touches something (names the bodies), the goal is out of
/// reach, or a value is out of range; NoPlanError when no path was found within the budget.
[[nodiscard]] reference::Trajectory PlanMotion(const scenario::Scenario& scenario,
                                               const scenario::RobotData& robot,
                                               const JointVector& start,
                                               const plant::MujocoPlantOptions& world,
                                               planning::PlanStatistics& statistics);

}  // namespace twin::run
