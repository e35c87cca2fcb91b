#pragma once

#include <cstddef>

#include "twin/core/joint_vector.h"

namespace twin {

/// Limits of the arm's joints: robot data, read from its limits.yaml and passed by value. Velocity,
/// acceleration, jerk, torque and torque rate are magnitudes, symmetric about zero.
struct JointLimits {
  JointVector q_min{};     ///< rad
  JointVector q_max{};     ///< rad
  JointVector dq_max{};    ///< rad/s
  JointVector ddq_max{};   ///< rad/s^2
  JointVector dddq_max{};  ///< rad/s^3
  JointVector tau_max{};   ///< Nm
  JointVector dtau_max{};  ///< Nm/s

  /// Where the velocity limit shrinks towards the ends of a joint's range (FR3): offset (rad/s) and
  /// deceleration (rad/s^2) of UpperVelocity(); a deceleration of zero: dq_max everywhere.
  JointVector velocity_offset{};
  JointVector deceleration{};

  /// Largest velocity of a joint at q (rad) in the direction of q_max, rad/s:
  ///   min(dq_max, max(0, sqrt(2 deceleration (q_max - q)) - velocity_offset)).
  /// Source: position_based_velocity_limits of the FR3's URDF, as libfranka 0.18 and later reads
  /// it. Threads: any. Real-time: noexcept.
  [[nodiscard]] double UpperVelocity(std::size_t joint, double q) const noexcept;
  /// The same towards q_min, as a negative number.
  [[nodiscard]] double LowerVelocity(std::size_t joint, double q) const noexcept;
  /// Bound of the magnitude of dq (rad/s) at q, in its direction, rad/s.
  [[nodiscard]] double VelocityLimit(std::size_t joint, double q, double dq) const noexcept;
  /// Distance from an end of a joint's range within which it cannot move towards that end, rad.
  [[nodiscard]] double StillZone(std::size_t joint) const noexcept;

  /// @throws InputError naming joint, field and value when a bound is not finite, not positive, or
  /// q_min >= q_max.
  void Validate() const;
};

/// Bounds of one kind of Cartesian motion, as magnitudes (Euclidean norms of three components; the
/// elbow has one).
struct CartesianBound {
  double dp_max = 0;    ///< velocity, m/s or rad/s
  double ddp_max = 0;   ///< acceleration, m/s^2 or rad/s^2
  double dddp_max = 0;  ///< jerk, m/s^3 or rad/s^3
};

/// Limits of the end effector's motion and of the elbow angle: robot data, read from limits.yaml.
struct CartesianLimits {
  CartesianBound translation;
  CartesianBound rotation;
  CartesianBound elbow;

  /// @throws InputError naming field and value when a bound is not finite or not positive.
  void Validate() const;
};

}  // namespace twin
