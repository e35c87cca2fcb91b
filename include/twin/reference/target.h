#pragma once

#include "twin/core/joint_vector.h"
#include "twin/reference/joint_target.h"
#include "twin/reference/pose_target.h"

namespace twin::reference {

/// What a source wants at one instant, in the terms of its command interface; the members of the
/// other interfaces do not count.
struct Target {
  JointTarget joint;      ///< joint position and joint velocity
  PoseTarget pose;        ///< Cartesian pose
  JointVector tau_J_d{};  ///< torque, Nm, without gravity and friction
};

}  // namespace twin::reference
