#pragma once

#include "twin/core/modes.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/trajectory.h"
#include "twin/robot/robot_config.h"
#include "twin/scenario/assembly.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// What a scenario comes to, short of a compiled model: each part made once and checked.
struct Plan {
  RobotData robot;
  reference::Trajectory trajectory;
  robot::RobotConfig config;
  MotionModes modes;
  loop::LoopKind loop = loop::LoopKind::kAsynchronous;
  loop::TickConfig tick;
  loop::ControllerLoopConfig controller_loop;
};

/// @throws InputError naming what is wrong and, where the scenario was read from a file, its line.
[[nodiscard]] Plan MakePlan(const Scenario& scenario, const Catalogue& catalogue,
                            const RunFiles& files);

}  // namespace twin::scenario
