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

/// The configuration of a served twin. The wire itself delays and reorders; of the link only the
/// losses and d_INT count.
/// @throws InputError also as LoadRobotData.
[[nodiscard]] robot::RobotConfig MakeServedConfig(const scenario::Scenario& scenario,
                                                  const RunFiles& files);

}  // namespace twin::run
