#pragma once

#include <array>

#include "twin/core/joint_vector.h"

// Interfaces between the controllers of arm, hand and base and their bodies: sensors in, drive
// commands out, once per cycle.
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

/// Sensors of the hand's drive.
struct HandSensors {
  double width = 0;   ///< distance between the fingers, m
  double dwidth = 0;  ///< its rate, m/s
  /// Force of each finger, N, estimated by the drive: its force less its own inertia and friction.
  /// Positive: outwards, so negative while the fingers hold an object between them.
  double force = 0;
};

/// Drive commands of the hand for one cycle. A dynamic hand applies force; the ideal hand, which
/// has no dynamics, follows the desired motion.
struct HandDrive {
  double force = 0;    ///< on each finger, N; positive opens
  double width_d = 0;  ///< m
};

/// Sensor of the vacuum gripper.
struct PumpSensors {
  double vacuum = 0;  ///< in the cups, below the air's pressure, Pa
};

/// Drive commands of the vacuum gripper for one cycle.
struct PumpDrive {
  double power = 0;   ///< of the pump, share of its most, in [0, 1]
  bool vents = true;  ///< the valve lets air in
};

/// Wheel sensors of a base. Wheels are ordered front left, front right, rear left, rear right;
/// positive rotation drives forwards.
struct WheelSensors {
  std::array<double, 4> q{};   ///< rotation since the start, rad, not wrapped
  std::array<double, 4> dq{};  ///< rad/s
};

/// Drive commands of a base for one cycle, in the order of WheelSensors.
struct WheelDrive {
  std::array<double, 4> tau{};  ///< per wheel, Nm
};

}  // namespace twin
