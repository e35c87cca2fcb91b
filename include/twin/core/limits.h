#pragma once

#include "twin/core/joint_vector.h"

namespace twin {

/// Limits of the arm's joints. Data of a robot, read from its limits.yaml; every user gets them as
/// a value. Velocity, acceleration, jerk, torque and torque rate are magnitudes, symmetric about
/// zero.
struct JointLimits {
  JointVector q_min{};     ///< rad
  JointVector q_max{};     ///< rad
  JointVector dq_max{};    ///< rad/s
  JointVector ddq_max{};   ///< rad/s^2
  JointVector dddq_max{};  ///< rad/s^3
  JointVector tau_max{};   ///< Nm
  JointVector dtau_max{};  ///< Nm/s

  /// @throws InputError naming joint, field and value when a bound is not finite, not positive, or
  /// q_min >= q_max.
  void Validate() const;
};

}  // namespace twin
