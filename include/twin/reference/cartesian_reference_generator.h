#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/pose_target.h"

namespace twin::reference {

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
