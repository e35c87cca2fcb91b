#pragma once

namespace twin::plant {

/// Stiffness of gear and torque sensor in ElasticityProfile::kStatic, all joints, Nm/rad. The
/// Panda's is not public. Decision: the largest K_theta that the robot accepts (FCI protocol 5),
/// since motor-side control cannot make the link stiffer than the transmission. The largest load,
/// 60 Nm at joint 2, then deflects it by 4 mrad.
inline constexpr double kJointStiffness = 14250;

}  // namespace twin::plant
