#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"

namespace twin::reference {

/// What the client-side rate limiter keeps to: libfranka 0.9.2's limits, a little inside the
/// robot's.
///
/// libfranka's rule for the Panda (include/franka/rate_limiting.h): every limit less kLimitEps =
/// 1e-3 of its unit; velocities moreover less kTolNumberPacketsLost T = 3 ms times the acceleration
/// so lowered, so that three lost packets, bridged at full acceleration, stay within. The robot
/// compares with its own limits, never with these.
///
/// The limits it starts from are those of the robot's data, which for the Panda are the header's,
/// but for one: its translational velocity is 2.0 m/s, whatever the robot's, where Franka's
/// documentation of the robot says 1.7 m/s. So a pose that this limiter lets move at more than 1.7
/// m/s is aborted by the robot (cartesian_motion_generator_velocity_limits_violation), with
/// libfranka as here; which of the two the robot goes by is not public.
struct ClientLimits {
  JointVector dq_max{};    ///< rad/s; kMaxJointVelocity: 2.129003 2.151503 2.144003 2.136503 ...
  JointVector ddq_max{};   ///< rad/s^2; kMaxJointAcceleration: 14.999 7.499 9.999 12.499 ...
  JointVector dddq_max{};  ///< rad/s^3; kMaxJointJerk: 7499.999 3749.999 4999.999 6249.999 ...
  JointVector dtau_max{};  ///< Nm/s; kMaxTorqueRate: 999.999
  CartesianBound translation;  ///< kMaxTranslational...: 1.960003 m/s, 12.999 m/s^2, 6499.999 m/s^3
  CartesianBound rotation;     ///< kMaxRotational...: 2.424003, 24.999, 12499.999 rad/s^n; of poses
                               ///< 0.99 of it (kFactorCartesianRotationPoseInterface, RateLimiter)
  CartesianBound elbow;        ///< kMaxElbow...: 2.144003, 9.999, 4999.999 rad/s^n

  /// @throws InputError naming the limit and its value when nothing is left of it.
  [[nodiscard]] static ClientLimits Of(const JointLimits& joint, const CartesianLimits& cartesian);
};

}  // namespace twin::reference
