#pragma once

#include "twin/control/registry.h"

namespace twin::controllers {

/// Adds all controllers of this folder by their controller.type in scenarios: joint_trajectory,
/// joint_position, joint_velocity, cartesian_pose, joint_trajectory_effort (also by its old name
/// joint_effort), compliance, gravity_hold. Each refuses a motion.interface other than its own.
void RegisterControllers(control::ControllerRegistry& registry);

}  // namespace twin::controllers
