#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"

namespace twin::reference {

/// The paper's reference generator in joint space:
///   q_s(k) = q_d(k) + T dq_ext(k) + lambda (q_ext(k) - q_d(k)),
/// with q_d the last commanded position from the state packet, q_ext and dq_ext the deposited
/// target and its velocity, and T = 1 ms. It continues from the reference that the robot accepted,
/// so jitter and late or lost commands cause no steps; a stalled source (dq_ext = 0) decays to the
/// last target with time constant T/lambda. It uses no time stamp. Source: the paper's section on
/// reference generation.
///
/// Limitations. It does not remove white noise of q_ext. If the source supplies dq_ext, the noise's
/// jerk is scaled by lambda sqrt(6/20), as its third difference becomes a second one times lambda;
/// if dq_ext is formed from the noisy q_ext, the noise passes in full. libfranka's low-pass of gain
/// g behind it scales the increment: the velocity follows g (s + lambda/T)/(s + g lambda/T) of the
/// target's, at 100 Hz 0.4 to 0.5 for motions with a period of 2 to 6 s. So switch it off.
///
/// Threads: stateless, any. Real-time: Next() is noexcept, O(1), allocates nothing.
class JointReferenceGenerator {
 public:
  /// @param lambda  correction per cycle, in (0, 1]; the paper uses 1e-3.
  /// @throws InputError naming the value and the range.
  explicit JointReferenceGenerator(double lambda = 1e-3);

  /// @param q_d     rad, of the answered state.
  /// @param target  q and dq are used.
  /// @returns q_s, rad.
  [[nodiscard]] JointVector Next(const JointVector& q_d,
                                 const JointTarget& target) const noexcept TWIN_REALTIME;

  [[nodiscard]] double lambda() const noexcept { return lambda_; }

 private:
  double lambda_;
};

/// The paper's reference generator for poses: the last commanded pose, advanced for one period by
/// the deposited twist [v; w] and by a proportional correction towards the deposited pose,
///   R(k) = exp(T w + lambda log(R_ext R_c^T)) R_c,
///   p(k) = p_c + T v + lambda (p_ext - p_c),
/// with R_c, p_c from O_T_EE_c of the state packet and T = 1 ms. JointReferenceGenerator's notes on
/// jitter, loss, noise and low-pass apply here too. The correction takes the shortest rotation; at
/// half a turn, either one. Source: the paper's section on reference generation.
///
/// The rotation is orthonormal up to rounding, however often it is fed back. When twist and error
/// are too small to change a rotation matrix, R(k) equals R_c bit for bit.
///
/// Threads: stateless, any. Real-time: Next() is noexcept, O(1), allocates nothing.
class CartesianReferenceGenerator {
 public:
  /// @param lambda  correction per cycle, in (0, 1]; the paper uses 1e-3.
  /// @throws InputError naming the value and the range.
  explicit CartesianReferenceGenerator(double lambda = 1e-3);

  /// @param O_T_EE_c  of the answered state.
  /// @returns the pose to command.
  [[nodiscard]] Transform Next(const Transform& O_T_EE_c,
                               const PoseTarget& target) const noexcept TWIN_REALTIME;

  [[nodiscard]] double lambda() const noexcept { return lambda_; }

 private:
  double lambda_;
};

}  // namespace twin::reference
