#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"

namespace twin::reference {

/// Limits of the client-side rate limiter: those of libfranka 0.9.2, slightly inside the robot's.
///
/// libfranka's rule for the Panda (include/franka/rate_limiting.h): every limit is reduced by
/// kLimitEps = 1e-3 of its unit. Velocities are further reduced by kTolNumberPacketsLost T = 3 ms
/// times the reduced acceleration, so that three lost packets, bridged at full acceleration, stay
/// within the limit. The robot compares with its own limits, never with these.
///
/// libfranka starts from the robot data (for the Panda those of its header) except for the
/// translational velocity: 2.0 m/s for any robot, where Franka's documentation of the robot says
/// 1.7 m/s. So the robot aborts a pose motion above 1.7 m/s that passes this limiter
/// (cartesian_motion_generator_velocity_limits_violation), with libfranka as here. Which of the two
/// the real robot applies is not public.
struct ClientLimits {
  JointVector dq_max{};    ///< rad/s; kMaxJointVelocity: 2.129003 2.151503 2.144003 2.136503 ...
  JointVector ddq_max{};   ///< rad/s^2; kMaxJointAcceleration: 14.999 7.499 9.999 12.499 ...
  JointVector dddq_max{};  ///< rad/s^3; kMaxJointJerk: 7499.999 3749.999 4999.999 6249.999 ...
  JointVector dtau_max{};  ///< Nm/s; kMaxTorqueRate: 999.999
  CartesianBound translation;  ///< kMaxTranslational...: 1.960003 m/s, 12.999 m/s^2, 6499.999 m/s^3
  CartesianBound rotation;     ///< kMaxRotational...: 2.424003, 24.999, 12499.999 rad/s^n; poses:
                               ///< 0.99 of it (kFactorCartesianRotationPoseInterface, RateLimiter)
  CartesianBound elbow;        ///< kMaxElbow...: 2.144003, 9.999, 4999.999 rad/s^n

  /// @throws InputError naming the limit and its value when the reduced limit is not positive.
  [[nodiscard]] static ClientLimits Of(const JointLimits& joint, const CartesianLimits& cartesian);
};

}  // namespace twin::reference
