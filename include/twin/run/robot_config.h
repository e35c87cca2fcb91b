#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "twin/planning/collision_world.h"
#include "twin/robot/robot_config.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Where the arm begins, rad: robot.q_start, else the motion's first waypoint. @pre there is one.
[[nodiscard]] JointVector StartOf(const scenario::Scenario& scenario);

/// The robot's configuration that a scenario asks for.
/// @throws InputError when a field is out of range; model::LimitBreach for a start outside the
/// scenario's limits.
[[nodiscard]] robot::RobotConfig MakeRobotConfig(const scenario::Scenario& scenario,
                                                 const scenario::RobotData& robot,
                                                 const RunFiles& files);

/// The configuration of a served twin. The wire itself delays and reorders; of the link only the
/// losses and d_INT count.
/// @throws InputError also as LoadRobotData.
[[nodiscard]] robot::RobotConfig MakeServedConfig(const scenario::Scenario& scenario,
                                                  const RunFiles& files);

/// The world around a scenario's robot for planning, with the scenario's limits.
/// @param options  of the robot's configuration. @throws as planning::CollisionWorld.
[[nodiscard]] std::unique_ptr<planning::CollisionWorld> MakeWorld(
    const scenario::Scenario& scenario, const scenario::RobotData& robot,
    const plant::MujocoPlantOptions& options);
/// The same among other arms. @param arms, own  as planning::CollisionWorld's.
[[nodiscard]] std::unique_ptr<planning::CollisionWorld> MakeWorld(
    const scenario::Scenario& scenario, const scenario::RobotData& robot,
    std::span<const plant::MujocoPlantOptions> arms, std::size_t own);

}  // namespace twin::run
