#pragma once

#include "twin/control/registry.h"

namespace twin::controllers {

/// Adds every controller of this folder, by the name that scenarios give as controller.type:
/// joint_trajectory, joint_position, joint_velocity, cartesian_pose, joint_trajectory_effort (also
/// by its old name joint_effort), compliance, gravity_hold. Each refuses a motion.interface that is
/// not its own.
void RegisterControllers(control::ControllerRegistry& registry);

}  // namespace twin::controllers
