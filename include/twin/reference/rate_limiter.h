#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"

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
///
/// Where a joint's velocity limit shrinks towards the ends of its range (FR3), so does the
/// client's, by the same reductions of the limit at q_d, as in libfranka 0.18
/// (computeUpperLimitsJointVelocity). Decision: never beyond zero, where libfranka would move a
/// joint at rest near an end away from it.
struct ClientLimits {
  JointVector dq_max{};    ///< rad/s; kMaxJointVelocity: 2.129003 2.151503 2.144003 2.136503 ...
  JointVector ddq_max{};   ///< rad/s^2; kMaxJointAcceleration: 14.999 7.499 9.999 12.499 ...
  JointVector dddq_max{};  ///< rad/s^3; kMaxJointJerk: 7499.999 3749.999 4999.999 6249.999 ...
  JointVector dtau_max{};  ///< Nm/s; kMaxTorqueRate: 999.999
  JointLimits joint{};     ///< of the robot: where the velocity limit shrinks; else unused
  CartesianBound translation;  ///< kMaxTranslational...: 1.960003 m/s, 12.999 m/s^2, 6499.999 m/s^3
  CartesianBound rotation;     ///< kMaxRotational...: 2.424003, 24.999, 12499.999 rad/s^n; poses:
                               ///< 0.99 of it (kFactorCartesianRotationPoseInterface, RateLimiter)
  CartesianBound elbow;        ///< kMaxElbow...: 2.144003, 9.999, 4999.999 rad/s^n

  /// @throws InputError naming the limit and its value when the reduced limit is not positive.
  [[nodiscard]] static ClientLimits Of(const JointLimits& joint, const CartesianLimits& cartesian);
};

}  // namespace twin::reference

// libfranka's client-side rate limiter: makes a command admissible, cycle by cycle.
//
// Law of one axis, with the limits V, A, J of velocity, acceleration and jerk, T = 1 ms; v, a the
// last commanded velocity and acceleration from the state (no memory of the client):
//   a_c  = a + T clamp(((v_c - v)/T - a)/T, -J, J)
//   v(k) = v + T clamp(a_c, max(J/A (-V - v), -A), min(J/A (V - v), A)).
// Positions are differenced to v_c and integrated again: p(k) = p + T v(k). The three axes of a
// Cartesian motion are limited together, by Euclidean norms: the jerk's norm by J, then the
// acceleration along its own direction by A and by J/A times the distance to the sphere of speed V.
//
// Where the velocity limit depends on the position, V and -V are those at q_d.
//
// Guarantees for any commands and constant limits (J/A T <= 1, as for every Panda limit):
// - One axis, from rest, every command delivered: velocity, acceleration and jerk within V, A, J.
// - One axis, runs of n <= 3 lost commands: velocity within V + 3 T A, the reason for the margin in
//   ClientLimits; acceleration within A, but 4 J T - A (1.0003 A) after three losses towards -V,
//   where the outer clamp wins; jerk of the resuming command only within (n + 1) J.
// - Three axes, every command delivered: speed within V, acceleration within A. Jerk within J only
//   while the speed is at least A^2/J below V; closer to V the speed limit rotates and shortens the
//   acceleration at once: jerk within max(J, A/T), 2 J for the Panda.
// Not guaranteed: positions are unbounded, so joint limits can be exceeded; a command that moves
// faster than the limits is followed with overshoot, not smoothed.
//
// A command within V, A and J passes up to rounding, as long as near V its acceleration is at most
// J/A (V - |v|). A command with a component that is not finite is unchanged (for joints, only that
// joint), so that the validity check behind rejects it.
//
// Where losses bring the state beyond V, libfranka's three-axis law takes the root of a negative
// number or demands more than A; ours brakes towards the sphere with at most A.
//
// All functions: any thread; real-time: noexcept, O(1), no allocation. Source: FCI protocol 5, rate
// limiter of libfranka 0.9.2.
namespace twin::reference {

/// Joint position. @param q_c  commanded, rad. The other arguments are those of the state.
[[nodiscard]] JointVector LimitJointPosition(const JointVector& q_c, const JointVector& q_d,
                                             const JointVector& dq_d, const JointVector& ddq_d,
                                             const ClientLimits& limits) noexcept TWIN_REALTIME;

/// Joint velocity. @param dq_c  commanded, rad/s. The other arguments are those of the state.
[[nodiscard]] JointVector LimitJointVelocity(const JointVector& dq_c, const JointVector& q_d,
                                             const JointVector& dq_d, const JointVector& ddq_d,
                                             const ClientLimits& limits) noexcept TWIN_REALTIME;

/// Torque: changes by at most dtau_max T. @param tau_J_d_c  commanded, Nm. @param tau_J_d  that of
/// the state.
[[nodiscard]] JointVector LimitTorque(const JointVector& tau_J_d_c, const JointVector& tau_J_d,
                                      const ClientLimits& limits) noexcept TWIN_REALTIME;

/// Pose. Translation and rotation are limited separately; the rotational velocity is
/// log(R_c R^T)/T, with 0.99 of the given limits.
/// @param O_T_EE_c  commanded. @param last, O_dP_EE_c, O_ddP_EE_c  pose, twist and its derivative
/// of the state.
[[nodiscard]] Transform LimitCartesianPose(const Transform& O_T_EE_c, const Transform& last,
                                           const Vector6& O_dP_EE_c, const Vector6& O_ddP_EE_c,
                                           const ClientLimits& limits) noexcept TWIN_REALTIME;

/// Twist. @param O_dP_EE_c  commanded. @param last, O_ddP_EE_c  twist and its derivative of the
/// state.
[[nodiscard]] Vector6 LimitCartesianVelocity(const Vector6& O_dP_EE_c, const Vector6& last,
                                             const Vector6& O_ddP_EE_c,
                                             const ClientLimits& limits) noexcept TWIN_REALTIME;

/// Elbow angle, in both Cartesian interfaces; the sign is unchanged. @param elbow_c  commanded.
/// @param last, delbow_c, ddelbow_c  elbow, its velocity and acceleration of the state.
[[nodiscard]] Elbow LimitElbow(const Elbow& elbow_c, const Elbow& last, const Elbow& delbow_c,
                               const Elbow& ddelbow_c,
                               const ClientLimits& limits) noexcept TWIN_REALTIME;

}  // namespace twin::reference
