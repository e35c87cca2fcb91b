#pragma once

#include "twin/core/joint_vector.h"
#include "twin/reference/joint_target.h"
#include "twin/reference/pose_target.h"

namespace twin::reference {

/// Target of a source at one instant, for its command interface; members of other interfaces are
/// ignored.
struct Target {
  JointTarget joint;      ///< joint position and joint velocity
  PoseTarget pose;        ///< Cartesian pose
  JointVector tau_J_d{};  ///< torque, Nm, without gravity and friction
};

}  // namespace twin::reference
