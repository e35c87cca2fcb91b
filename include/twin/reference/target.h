#pragma once

#include "twin/core/joint_vector.h"

namespace twin::reference {

/// Target of a joint-space source at one instant.
struct JointTarget {
  JointVector q{};    ///< rad
  JointVector dq{};   ///< rad/s
  JointVector ddq{};  ///< rad/s^2
};

/// Target of a Cartesian source for the end effector at one instant.
struct PoseTarget {
  Transform O_T_EE = kIdentityTransform;  ///< pose of EE in the base
  Vector6 O_dP_EE{};                      ///< its twist [v; w], base axes, at the EE origin
};

/// Target of a source at one instant, for its command interface; members of other interfaces are
/// ignored.
struct Target {
  JointTarget joint;      ///< joint position and joint velocity
  PoseTarget pose;        ///< Cartesian pose
  JointVector tau_J_d{};  ///< torque, Nm, without gravity and friction
};

}  // namespace twin::reference
