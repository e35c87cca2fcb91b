#pragma once

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::model {

/// Displacement from pose X to pose X_c, for small differences, at the origin of X in base axes:
/// [p_c - p; sin(angle) axis of R_c R^T], m and rad. Exactly zero for equal poses. If R_c is
/// slightly oblique, its nearest rotation is used (polar decomposition).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Vector6 Displacement(const Transform& X, const Transform& X_c) noexcept TWIN_REALTIME;

/// (J^T J + alpha I)^-1 J^T v, computed as the equal J^T (J J^T + alpha I)^-1 v: joint velocities
/// that approximate a twist at limited speed, with alpha the weight of speed.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param J  6 x 7, column-major. @param v  twist, m/s and rad/s. @returns rad/s.
[[nodiscard]] JointVector DampedLeastSquares(const Jacobian& J, const Vector6& v,
                                             double alpha) noexcept TWIN_REALTIME;

/// Moving joints and damping of inverse kinematics.
struct InverseKinematicsOptions {
  bool joint_3_moves = true;  ///< else the other joints reach the displacement
  double s_0 = 0;             ///< dexterity below which damping acts
  double lambda_max = 0;      ///< damping at a singularity
};

/// Inverse kinematics of the arm, linearised at one configuration: the smallest joint motion for a
/// small displacement dx of the flange,
///
///   dq = W J^T (J W J^T + lambda^2 I)^-1 dx,
///
/// with J the Jacobian of the flange in base axes and W the identity without a fixed joint. The
/// damping lambda depends on the dexterity s, s^-2 = trace((J W J^T)^-1), the sum of the inverse
/// squares of J's singular values in m/rad and rad/rad: s is smooth, at most the smallest singular
/// value and at least 1/sqrt(6) of it.
///
///   lambda^2 = lambda_max^2 (1 - (s / s_0)^2)^3 below s_0, exactly zero above.
///
/// lambda^2 has two continuous derivatives, so damping sets in smoothly. Damping leaves the part
/// lambda^2 (J W J^T + lambda^2 I)^-1 dx unreached.
/// Source: Nakamura, Hanafusa, "Inverse kinematic solutions with singularity robustness", 1986;
/// dexterity and the power of three are decisions.
///
/// Threads: one per object; built for a cycle. Real-time: noexcept, allocates nothing. Input that
/// is not finite gives results that are not finite.
class InverseKinematics {
 public:
  using Options = InverseKinematicsOptions;

  /// @param J  of the flange, zero Jacobian.
  explicit InverseKinematics(const Jacobian& J, const Options& options = {}) noexcept TWIN_REALTIME;

  /// s; 0 if the arm is singular up to rounding.
  [[nodiscard]] double dexterity() const noexcept { return s_; }
  /// lambda^2.
  [[nodiscard]] double damping() const noexcept { return damping_; }

  /// @returns J dq, all seven joints.
  [[nodiscard]] Vector6 Moved(const JointVector& dq) const noexcept TWIN_REALTIME;

  /// Solution for a displacement of the flange.
  struct Solution {
    JointVector dq{};  ///< rad
    Vector6 missed{};  ///< unreached part of dx; zero without damping
  };
  [[nodiscard]] Solution Solve(const Vector6& dx) const noexcept TWIN_REALTIME;

 private:
  /// Inverse of a symmetric 6 x 6 matrix in 3 x 3 blocks, by the Schur complement of the lower
  /// right block: A = [P Q^T; Q S], M = P - Q^T S^-1 Q.
  struct BlockInverse {
    Eigen::Matrix3d S_inverse;
    Eigen::Matrix3d S_inverse_Q;
    Eigen::Matrix3d M_inverse;
    double det = 0;  ///< of A

    explicit BlockInverse(const Eigen::Matrix<double, 6, 6>& A) noexcept;
    [[nodiscard]] double Trace() const noexcept;
    [[nodiscard]] Vector6 Solve(const Vector6& b) const noexcept;
  };
  [[nodiscard]] Eigen::Matrix<double, 6, 6> Gram() const noexcept;

  Jacobian J_;
  bool joint_3_moves_;
  double s_ = 0;
  double damping_ = 0;
  BlockInverse inverse_;
};

}  // namespace twin::model
