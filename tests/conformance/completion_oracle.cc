#include "conformance/completion_oracle.h"

#include <cmath>

#include <Eigen/Core>

#include "conformance/pose_math.h"
#include "support/dense.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"

namespace twin::test {
namespace {

using Matrix67 = Eigen::Matrix<double, 6, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Column6 = Eigen::Matrix<double, 6, 1>;

constexpr double kFlipAngle = -0.467002423653011;

Matrix67 JacobianOf(const JointVector& q, const Transform& F_T_EE) {
  const model::Jacobian columns =
      model::ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, q, F_T_EE);
  return Eigen::Map<const Matrix67>(columns.data());
}

}  // namespace

double SmallestSingularValue(const JointVector& q, bool joint_3_moves) {
  Matrix67 J = JacobianOf(q, kIdentityTransform);
  if (!joint_3_moves) J.col(2).setZero();
  return SingularValues(J)[5];
}

bool IsRegular(const JointVector& q, bool joint_3_moves) {
  constexpr double kWellAbove = 0.12;
  return std::abs(q[3] - kFlipAngle) > 0.08 && SmallestSingularValue(q, joint_3_moves) > kWellAbove;
}

JointVector Complete(const JointVector& q_d, const Transform& F_T_EE, const Transform& pose,
                     const std::optional<double>& elbow) {
  JointVector start = q_d;
  if (elbow) start[2] = *elbow;
  JointVector q = start;
  for (int i = 0; i < 8; ++i) {
    Matrix67 J = JacobianOf(q, F_T_EE);
    if (elbow) J.col(2).setZero();
    const Transform now = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, F_T_EE);
    const Vector6 way = TwistBetween(now, pose);
    const Column6 error = Eigen::Map<const Column6>(way.data()) * kCycleSeconds;
    const Vector7 gone =
        Eigen::Map<const Vector7>(q.data()) - Eigen::Map<const Vector7>(start.data());
    // The least distance from the start: the whole way lies in the rows of J.
    const Vector7 whole = DampedLeastSquares(J, error + J * gone, 0);
    for (std::size_t k = 0; k < kJoints; ++k) {
      q[k] = start[k] + whole[static_cast<Eigen::Index>(k)];
    }
    if ((whole - gone).norm() < 1e-15) break;
  }
  return q;
}

double CompletionNoise(const JointMotion& step) {
  using Eigen::Map;
  constexpr double kT = kCycleSeconds;
  const double way = kT * Map<const Vector7>(step.dq.data()).norm();
  const double beside = kT * kT * Map<const Vector7>(step.ddq.data()).norm();
  return 2e-9 + way * beside;
}

}  // namespace twin::test
