#pragma once

#include <memory>

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

/// The world around a scenario's robot for planning, with the scenario's limits. Its neighbours
/// stand where they start, hands open. @throws as planning::CollisionWorld.
[[nodiscard]] std::unique_ptr<planning::CollisionWorld> MakeWorld(
    const scenario::Scenario& scenario, const scenario::RobotData& robot, const RunFiles& files);

}  // namespace twin::run
