#pragma once

#include "twin/core/joint_vector.h"

namespace twin {

/// Joint sensors of the arm. Units rad, rad/s, Nm.
struct JointSensors {
  JointVector q{};       ///< link position
  JointVector dq{};      ///< link velocity
  JointVector tau_J{};   ///< link-side torque behind the gear: gravity, link inertia, link friction
                         ///< and contact; without rotor inertia
  JointVector theta{};   ///< motor position, reflected to the link
  JointVector dtheta{};  ///< motor velocity, reflected to the link
};

/// Controller output to the joints for one cycle. A dynamic plant applies tau; the ideal plant,
/// which has no dynamics, follows the desired motion.
struct JointDrive {
  JointVector tau{};    ///< motor torque reflected to the link, with gravity compensation, Nm
  JointVector q_d{};    ///< rad
  JointVector dq_d{};   ///< rad/s
  JointVector ddq_d{};  ///< rad/s^2
  bool brakes = false;  ///< closed: the joints are locked, tau has no effect
};

}  // namespace twin
