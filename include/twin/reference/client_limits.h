#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"

namespace twin::reference {

/// What the client-side rate limiter keeps to: the robot's limits, a little inside.
///
/// libfranka's rule for the Panda: every limit less 1e-3 of its unit; velocities moreover less
/// 3 T ddq_max (of the acceleration so lowered), so that three lost packets, bridged at full
/// acceleration, stay within. The robot compares with its own limits, never with these. libfranka
/// 0.9.2 reckons from a translational velocity of 2.0 m/s where Franka's documentation says 1.7
/// m/s; here it is what the data say. Source: FCI protocol 5, limits of libfranka 0.9.2's rate
/// limiting.
struct ClientLimits {
  JointVector dq_max{};    ///< rad/s
  JointVector ddq_max{};   ///< rad/s^2
  JointVector dddq_max{};  ///< rad/s^3
  JointVector dtau_max{};  ///< Nm/s
  CartesianBound translation;
  CartesianBound rotation;
  CartesianBound elbow;

  /// @throws InputError naming the limit and its value when nothing is left of it.
  [[nodiscard]] static ClientLimits Of(const JointLimits& joint, const CartesianLimits& cartesian);
};

}  // namespace twin::reference
