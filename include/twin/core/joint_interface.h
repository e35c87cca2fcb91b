#pragma once

#include "twin/core/joint_vector.h"

namespace twin {

/// What the arm's joint sensors report. Units rad, rad/s, Nm.
struct JointSensors {
  JointVector q{};       ///< link position
  JointVector dq{};      ///< link velocity
  JointVector tau_J{};   ///< link-side torque behind the gear: gravity, link inertia, friction of
                         ///< the link and contact; not the rotor's inertia
  JointVector theta{};   ///< motor position, seen at the link
  JointVector dtheta{};  ///< motor velocity, seen at the link
};

/// What the robot's controller hands to the joints for one cycle. A dynamic plant acts on tau; the
/// ideal plant, which has no dynamics, follows the desired motion.
struct JointDrive {
  JointVector tau{};    ///< motor torque seen at the link, gravity compensation included, Nm
  JointVector q_d{};    ///< rad
  JointVector dq_d{};   ///< rad/s
  JointVector ddq_d{};  ///< rad/s^2
  bool brakes = false;  ///< closed: the joints are held where they are, whatever tau says
};

}  // namespace twin
