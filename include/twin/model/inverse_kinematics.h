#pragma once

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::model {

/// How far pose X is from pose X_c, as a small displacement of the origin of X in base axes:
/// [p_c - p; sin(angle) axis of R_c R^T], m and rad. Exactly zero for equal poses. Where R_c is a
/// little oblique, its nearest rotation counts (the polar one).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Vector6 Displacement(const Transform& X, const Transform& X_c) noexcept TWIN_REALTIME;

/// (J^T J + alpha I)^-1 J^T v, computed as J^T (J J^T + alpha I)^-1 v, which is the same: joint
/// velocities that come near to a twist without being fast, alpha the price of speed.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param J  6 x 7, column-major. @param v  twist, m/s and rad/s. @returns rad/s.
[[nodiscard]] JointVector DampedLeastSquares(const Jacobian& J, const Vector6& v,
                                             double alpha) noexcept TWIN_REALTIME;

/// Which joints may move, and how inverse kinematics is damped.
struct InverseKinematicsOptions {
  bool joint_3_moves = true;  ///< else the others reach the displacement alone
  double s_0 = 0;             ///< dexterity below which it is damped
  double lambda_max = 0;      ///< damping where the arm is singular
};

/// Inverse kinematics of the arm, linearised at one configuration: the smallest joint motion that
/// makes a small displacement dx of the flange,
///
///   dq = W J^T (J W J^T + lambda^2 I)^-1 dx,
///
/// J the Jacobian of the flange in base axes, W the identity without the joint that may not move.
/// The damping lambda depends on the dexterity s, s^-2 = trace((J W J^T)^-1), the sum of the
/// inverse squares of J's singular values in m/rad and rad/rad: s is smooth, at most the smallest
/// singular value and at least 1/sqrt(6) of it.
///
///   lambda^2 = lambda_max^2 (1 - (s / s_0)^2)^3 below s_0, exactly zero above.
///
/// lambda^2 has two continuous derivatives, so the way into the damped region is smooth. Damped,
/// a part of dx is not reached: lambda^2 (J W J^T + lambda^2 I)^-1 dx.
/// Source: Nakamura, Hanafusa, "Inverse kinematic solutions with singularity robustness", 1986;
/// measure and the power of three are ours.
///
/// Threads: one per object; built for a cycle. Real-time: noexcept, allocates nothing. What is not
/// finite gives a result that is not.
class InverseKinematics {
 public:
  using Options = InverseKinematicsOptions;

  InverseKinematics(const ArmModel& arm, const Configuration& q,
                    const Options& options = {}) noexcept TWIN_REALTIME;

  /// s; 0 where the arm is singular to rounding.
  [[nodiscard]] double dexterity() const noexcept { return s_; }
  /// lambda^2.
  [[nodiscard]] double damping() const noexcept { return damping_; }

  /// @returns J dq, all seven joints.
  [[nodiscard]] Vector6 Moved(const JointVector& dq) const noexcept TWIN_REALTIME;

  /// A displacement of the flange: what it takes and what it leaves.
  struct Solution {
    JointVector dq{};  ///< rad
    Vector6 missed{};  ///< part of dx that is not reached; zero when not damped
  };
  [[nodiscard]] Solution Solve(const Vector6& dx) const noexcept TWIN_REALTIME;

 private:
  /// Inverse of a symmetric 6 x 6 matrix in blocks of three, by the Schur complement of the lower
  /// right one: A = [P Q^T; Q S], M = P - Q^T S^-1 Q.
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
