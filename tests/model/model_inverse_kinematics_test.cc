#include "twin/model/inverse_kinematics.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "model/model_samples.h"
#include "support/dense.h"
#include "support/realtime_guard.h"
#include "twin/model/transform.h"

namespace twin::model::model_inverse_kinematics_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::uint64_t kSamples = 200;

/// J, without the column of joint 3 when that may not move.
MatrixXd JacobianOf(const JointVector& q, bool joint_3_moves) {
  const Jacobian J = ArmModel::Panda().ZeroJacobian(Frame::kFlange, q);
  MatrixXd matrix = Eigen::Map<const Eigen::Matrix<double, 6, 7>>(J.data());
  if (!joint_3_moves) matrix.col(2).setZero();
  return matrix;
}

/// The reference: 1 / sqrt(sum of 1/sigma^2), by singular values.
double DexterityOf(const MatrixXd& J) {
  return 1 / test::SingularValues(J).cwiseInverse().norm();
}

Jacobian FlangeAt(const JointVector& q) {
  return ArmModel::Panda().ZeroJacobian(Frame::kFlange, q);
}

Vector6 SmallStep(std::uint64_t index) {
  const Random random(7, RandomStream::kTest);
  Vector6 dx;
  for (std::uint32_t i = 0; i < 6; ++i) dx[i] = 1e-3 * (2 * random.Uniform(index, i) - 1);
  return dx;
}

VectorXd AsVector(const Vector6& x) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(x.data());
}
VectorXd AsVector(const JointVector& x) {
  return Eigen::Map<const Eigen::Matrix<double, 7, 1>>(x.data());
}

TEST(DisplacementTest, OfEqualPosesIsExactlyZero) {
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const Transform X = ArmModel::Panda().Pose(Frame::kEndEffector, SampleOf(k).q, kHandPose);
    EXPECT_EQ(Displacement(X, X), Vector6{});
  }
}

TEST(DisplacementTest, IsTranslationAndSineOfTheTurn) {
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const Transform X = ArmModel::Panda().Pose(Frame::kFlange, SampleOf(k).q);
    const Vector6 step = SmallStep(k);
    const Eigen::Vector3d phi = 500 * Eigen::Vector3d(step[3], step[4], step[5]);
    const Eigen::Vector3d p = Position(X) + Eigen::Vector3d(step[0], step[1], step[2]);
    const Vector6 dx = Displacement(X, Turned(X, phi, p));
    const Eigen::Vector3d expected = std::sin(phi.norm()) * phi.normalized();
    for (int i = 0; i < 3; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_NEAR(dx[at], step[at], 1e-15);
      EXPECT_NEAR(dx[3 + at], expected[i], 1e-14);
    }
  }
}

TEST(DisplacementTest, OfAnObliquePoseIsThatOfItsNearestRotation) {
  const Transform X = ArmModel::Panda().Pose(Frame::kFlange, kReady);
  Eigen::Matrix3d stretch;  // symmetric: R stretch has R as its polar rotation
  stretch << 1 + 4e-6, 2e-6, -1e-6, 2e-6, 1 - 3e-6, 3e-6, -1e-6, 3e-6, 1 + 1e-6;
  Transform oblique = X;
  Eigen::Map<Eigen::Matrix4d> matrix(oblique.data());
  matrix.topLeftCorner<3, 3>() = (matrix.topLeftCorner<3, 3>() * stretch).eval();
  for (const double dx : Displacement(X, oblique)) EXPECT_NEAR(dx, 0, 1e-15);
}

class InverseKinematicsTest : public ::testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] bool joint_3_moves() const { return GetParam(); }
};

TEST_P(InverseKinematicsTest, FindsTheSmallestStepThatReachesADisplacement) {
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const JointVector q = SampleOf(k).q;
    const MatrixXd J = JacobianOf(q, joint_3_moves());
    if (DexterityOf(J) < 0.01) continue;
    const InverseKinematics ik(FlangeAt(q), {.joint_3_moves = joint_3_moves()});
    const Vector6 dx = SmallStep(k);
    const auto [dq, missed] = ik.Solve(dx);
    const VectorXd expected = test::LeastSquares(J, AsVector(dx));
    EXPECT_LT((AsVector(dq) - expected).norm(), 1e-9 * expected.norm()) << "sample " << k;
    EXPECT_LT((AsVector(ik.Moved(dq)) - AsVector(dx)).norm(), 1e-12) << "sample " << k;
    EXPECT_EQ(missed, Vector6{});
    EXPECT_EQ(ik.damping(), 0);
    if (!joint_3_moves()) {
      EXPECT_EQ(dq[2], 0);
    }
  }
}

TEST_P(InverseKinematicsTest, DexterityIsThatOfTheSingularValues) {
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const JointVector q = SampleOf(k).q;
    const MatrixXd J = JacobianOf(q, joint_3_moves());
    const double s = DexterityOf(J);
    const InverseKinematics ik(FlangeAt(q), {.joint_3_moves = joint_3_moves()});
    EXPECT_NEAR(ik.dexterity(), s, 1e-7 * s + 1e-7) << "sample " << k;
    const double sigma = test::SingularValues(J)[5];
    EXPECT_LE(ik.dexterity(), sigma + 1e-7);
    EXPECT_GE(ik.dexterity(), sigma / std::sqrt(6) - 1e-7);
  }
}

TEST_P(InverseKinematicsTest, DampedItSolvesTheDampedEquation) {
  constexpr double kS0 = 0.2;  // more than any configuration has
  constexpr double kLambda = 0.1;
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const JointVector q = SampleOf(k).q;
    const MatrixXd J = JacobianOf(q, joint_3_moves());
    const double s = DexterityOf(J);
    const double damping = kLambda * kLambda * std::pow(1 - s * s / (kS0 * kS0), 3);
    const InverseKinematics ik(
        FlangeAt(q), {.joint_3_moves = joint_3_moves(), .s_0 = kS0, .lambda_max = kLambda});
    EXPECT_NEAR(ik.damping(), damping, 1e-9);
    const Vector6 dx = SmallStep(k);
    const auto [dq, missed] = ik.Solve(dx);
    const VectorXd expected = test::DampedLeastSquares(J, AsVector(dx), damping);
    EXPECT_LT((AsVector(dq) - expected).norm(), 1e-7 * expected.norm()) << "sample " << k;
    EXPECT_LT((AsVector(missed) - (AsVector(dx) - AsVector(ik.Moved(dq)))).norm(), 1e-12);
  }
}

TEST_P(InverseKinematicsTest, IsDampedBelowTheBoundOnly) {
  const InverseKinematics plain(FlangeAt(kReady), {.joint_3_moves = joint_3_moves()});
  const double s = plain.dexterity();
  const auto damping = [&](double s_0) {
    return InverseKinematics(FlangeAt(kReady),
                             {.joint_3_moves = joint_3_moves(), .s_0 = s_0, .lambda_max = 1})
        .damping();
  };
  EXPECT_EQ(damping(s), 0);
  EXPECT_EQ(damping(s * 0.999), 0);
  EXPECT_NEAR(damping(s * 1.001), 8e-9, 1e-10);  // (1 - 1/1.001^2)^3
}

TEST_P(InverseKinematicsTest, FullyDampedItStaysFiniteWhereTheArmIsSingular) {
  const JointVector singular[] = {
      {},                                          // all axes in one plane
      {0, 0.9, 0, -0.467002423653011, 0, 1.2, 0},  // stretched out
      {0, 0.9, 0, 0, 0, 1.2, 0},
      {0, 0, 0, -1.5, 0, 0, 0},
  };
  for (const JointVector& q : singular) {
    const InverseKinematics ik(FlangeAt(q),
                               {.joint_3_moves = joint_3_moves(), .s_0 = 0.05, .lambda_max = 0.05});
    EXPECT_GE(ik.dexterity(), 0);
    EXPECT_LE(ik.damping(), 0.0025 * (1 + 1e-15));
    const auto [dq, missed] = ik.Solve({0.1, -0.1, 0.1, 0.1, -0.1, 0.1});
    for (const double x : dq) EXPECT_LE(std::abs(x), 0.25 / 0.05);  // |dx| / (2 lambda)
    for (const double x : missed) EXPECT_TRUE(std::isfinite(x));
  }
  const InverseKinematics stretched(FlangeAt(singular[1]), {.joint_3_moves = joint_3_moves()});
  EXPECT_LT(stretched.dexterity(), 1e-7);
}

TEST_P(InverseKinematicsTest, MovesAllJoints) {
  const Sample sample = SampleOf(3);
  const InverseKinematics ik(FlangeAt(sample.q), {.joint_3_moves = joint_3_moves()});
  const Vector6 expected = ArmModel::Panda().Twist(Frame::kFlange, sample.q, sample.dq);
  const Vector6 moved = ik.Moved(sample.dq);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(moved[i], expected[i], 1e-14);
}

TEST_P(InverseKinematicsTest, AllocatesNothing) {
  double sum = 0;
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const InverseKinematics ik(FlangeAt(SampleOf(k).q),
                               {.joint_3_moves = joint_3_moves(), .s_0 = 0.1, .lambda_max = 0.1});
    sum += ik.Solve(SmallStep(k)).dq[0];
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
  EXPECT_TRUE(std::isfinite(sum));
}

INSTANTIATE_TEST_SUITE_P(Elbow, InverseKinematicsTest, ::testing::Bool(), [](const auto& info) {
  return info.param ? "JointThreeMoves" : "JointThreeFixed";
});

}  // namespace
}  // namespace twin::model::model_inverse_kinematics_test
