#pragma once

namespace twin::plant {

/// Stiffness of gear and torque sensor of ElasticityProfile::kStatic, all joints, Nm/rad. No figure
/// is public for the Panda. Our decision: the largest K_theta that the robot accepts (FCI protocol
/// 5) - a spring that is steered at the motor can make the link no stiffer than what lies between.
/// The longest lever, 60 Nm at joint 2, then bends it by 4 mrad.
inline constexpr double kJointStiffness = 14250;

}  // namespace twin::plant
