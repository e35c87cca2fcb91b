#pragma once

#include "twin/robot/robot_config.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// The robot's configuration that a scenario asks for.
/// @throws InputError when a field is out of range.
[[nodiscard]] robot::RobotConfig MakeRobotConfig(const scenario::Scenario& scenario,
                                                 const scenario::RobotData& robot,
                                                 const RunFiles& files);

/// The same of a twin that is served, with the data of its robot: the wire itself delays and
/// reorders, so that of the link only the losses and d_INT are left.
/// @throws InputError also as LoadRobotData.
[[nodiscard]] robot::RobotConfig MakeServedConfig(const scenario::Scenario& scenario,
                                                  const RunFiles& files);

}  // namespace twin::run
