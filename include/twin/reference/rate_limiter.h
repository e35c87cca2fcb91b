#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/client_limits.h"

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
// Guarantees for any commands (J/A T <= 1, as for every Panda limit):
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
[[nodiscard]] JointVector LimitJointVelocity(const JointVector& dq_c, const JointVector& dq_d,
                                             const JointVector& ddq_d,
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
