#include "twin/model/inverse_kinematics.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "model/vector3.h"

namespace twin::model {

using internal::Cross;
using internal::operator+;
using internal::operator*;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Determinants of J W J^T reach 1e-2; below this they are rounding errors of either sign.
constexpr double kSingularDeterminant = 1e-18;

Vector3 Column(const Transform& X, std::size_t c) noexcept {
  return {X[4 * c], X[4 * c + 1], X[4 * c + 2]};
}

}  // namespace

Vector6 Displacement(const Transform& X, const Transform& X_c) noexcept {
  Vector3 turn{};
  for (std::size_t c = 0; c < 3; ++c) turn = turn + Cross(Column(X, c), Column(X_c, c));
  turn = 0.5 * turn;
  return {X_c[12] - X[12], X_c[13] - X[13], X_c[14] - X[14], turn[0], turn[1], turn[2]};
}

JointVector DampedLeastSquares(const Jacobian& J, const Vector6& v, double alpha) noexcept {
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> jacobian(J.data());
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> twist(v.data());
  const Matrix6 A = jacobian * jacobian.transpose() + alpha * Matrix6::Identity();
  JointVector dq;
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(dq.data()) = jacobian.transpose() * A.ldlt().solve(twist);
  return dq;
}

InverseKinematics::InverseKinematics(const Jacobian& J, const Options& options) noexcept
    : J_(J), joint_3_moves_(options.joint_3_moves), inverse_(Gram()) {
  const bool is_regular = inverse_.det > kSingularDeterminant;
  const double s_squared = is_regular ? 1 / inverse_.Trace() : 0;
  s_ = std::sqrt(s_squared);
  const double inside = 1 - s_squared / (options.s_0 * options.s_0);
  if (!(inside > 0)) return;
  damping_ = options.lambda_max * options.lambda_max * inside * inside * inside;
  inverse_ = BlockInverse(Gram() + damping_ * Matrix6::Identity());
}

Eigen::Matrix<double, 6, 6> InverseKinematics::Gram() const noexcept {
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(J_.data());
  Matrix6 A = J.lazyProduct(J.transpose());
  if (!joint_3_moves_) A -= J.col(2).lazyProduct(J.col(2).transpose());
  return A;
}

InverseKinematics::BlockInverse::BlockInverse(const Matrix6& A) noexcept {
  const Eigen::Matrix3d S = A.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d Q = A.bottomLeftCorner<3, 3>();
  S_inverse = S.inverse();
  S_inverse_Q = S_inverse * Q;
  const Eigen::Matrix3d M = A.topLeftCorner<3, 3>() - Q.transpose() * S_inverse_Q;
  M_inverse = M.inverse();
  det = S.determinant() * M.determinant();
}

double InverseKinematics::BlockInverse::Trace() const noexcept {
  // The lower right block of the inverse is S^-1 + (S^-1 Q) M^-1 (S^-1 Q)^T.
  return M_inverse.trace() + S_inverse.trace() +
         (S_inverse_Q.transpose() * S_inverse_Q).cwiseProduct(M_inverse).sum();
}

Vector6 InverseKinematics::BlockInverse::Solve(const Vector6& b) const noexcept {
  const Eigen::Map<const Eigen::Vector3d> b_v(b.data());
  const Eigen::Map<const Eigen::Vector3d> b_w(b.data() + 3);
  Vector6 x;
  Eigen::Map<Eigen::Vector3d> x_v(x.data());
  Eigen::Map<Eigen::Vector3d> x_w(x.data() + 3);
  x_v = M_inverse * (b_v - S_inverse_Q.transpose() * b_w);
  x_w = S_inverse * b_w - S_inverse_Q * x_v;
  return x;
}

Vector6 InverseKinematics::Moved(const JointVector& dq) const noexcept {
  Vector6 dx{};
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    for (std::size_t r = 0; r < 6; ++r) dx[r] += J_[6 * joint + r] * dq[joint];
  }
  return dx;
}

InverseKinematics::Solution InverseKinematics::Solve(const Vector6& dx) const noexcept {
  Solution solution;
  const Vector6 y = inverse_.Solve(dx);
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    if (joint == 2 && !joint_3_moves_) continue;
    for (std::size_t r = 0; r < 6; ++r) solution.dq[joint] += J_[6 * joint + r] * y[r];
  }
  for (std::size_t r = 0; r < 6; ++r) solution.missed[r] = damping_ * y[r];
  return solution;
}

}  // namespace twin::model
