#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Core>

#include "model_samples.h"
#include "support/dense.h"
#include "support/realtime_guard.h"
#include "twin/model/arm_model.h"

namespace twin::model::arm_model_dynamics_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

constexpr std::uint64_t kSamples = 200;

using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix67 = Eigen::Matrix<double, 6, 7>;

Matrix7 ToMatrix(const JointMatrix& M) {
  return Eigen::Map<const Matrix7>(M.data());
}
Vector7 ToVector(const JointVector& v) {
  return Eigen::Map<const Vector7>(v.data());
}

JointVector Moved(const JointVector& q, const JointVector& dq, double t) {
  JointVector moved = q;
  for (std::size_t i = 0; i < kJoints; ++i) moved[i] += t * dq[i];
  return moved;
}

/// Jacobian of the payload's centre of mass, base axes.
Matrix67 CentreJacobian(const ArmModel& arm, const JointVector& q, const Payload& payload) {
  Transform F_T_C = kIdentityTransform;
  for (std::size_t k = 0; k < 3; ++k) F_T_C[12 + k] = payload.F_x_C[k];
  const Jacobian J = arm.ZeroJacobian(Frame::kEndEffector, q, F_T_C);
  return Eigen::Map<const Matrix67>(J.data());
}

/// Rotation of the flange in the base.
Eigen::Matrix3d FlangeRotation(const ArmModel& arm, const JointVector& q) {
  const Transform X = arm.Pose(Frame::kFlange, q);
  return Eigen::Map<const Eigen::Matrix4d>(X.data()).topLeftCorner<3, 3>();
}

TEST(ArmModelDynamicsTest, MassMatrixIsExactlySymmetric) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Matrix7 M = ToMatrix(ArmModel::Panda().MassMatrix(SampleOf(i).q, kLump));
    EXPECT_EQ(M, M.transpose()) << "sample " << i;
  }
}

TEST(ArmModelDynamicsTest, RegressorTimesParametersIsInverseDynamics) {
  const ArmModel& arm = ArmModel::PandaPlant();
  Eigen::Matrix<double, 80, 1> pi;
  Eigen::Index next = 0;
  const auto put = [&](const MassMoments& body) {
    for (const double value : {body.m, body.h[0], body.h[1], body.h[2], body.I.xx, body.I.xy,
                               body.I.xz, body.I.yy, body.I.yz, body.I.zz}) {
      pi[next++] = value;
    }
  };
  for (const MassMoments& link : arm.links()) put(link);
  const Matrix3& I = kLump.I;
  put(MassMoments::Of(kLump.m, kLump.F_x_C, {I[0], I[1], I[2], I[4], I[5], I[8]}));
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto [q, dq, ddq] = SampleOf(i);
    const Regressor Y = ArmModel::RegressorOf(q, dq, ddq, kTilted);
    const Vector7 tau =
        Eigen::Map<const Eigen::Matrix<double, 7, 80, Eigen::RowMajor>>(Y.data()) * pi;
    const Vector7 expected = ToVector(arm.InverseDynamics(q, dq, ddq, kLump, kTilted));
    EXPECT_LT((tau - expected).norm(), 1e-12 * expected.norm()) << "sample " << i;
  }
}

TEST(ArmModelDynamicsTest, MassMatrixIsPositiveDefinite) {
  for (const ArmModel* arm : {&ArmModel::Panda(), &ArmModel::PandaPlant()}) {
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      for (const Payload& payload : {Payload{}, kHand, kLump}) {
        const Matrix7 M = ToMatrix(arm->MassMatrix(SampleOf(i).q, payload));
        // Its eigenvalues are above 3e-4.
        EXPECT_TRUE(test::IsPositiveDefinite(M - 3e-4 * Matrix7::Identity())) << "sample " << i;
      }
    }
  }
}

TEST(ArmModelDynamicsTest, InverseDynamicsIsTheSumOfItsParts) {
  const ArmModel& arm = ArmModel::Panda();
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto [q, dq, ddq] = SampleOf(i);
    const Vector7 sum = ToMatrix(arm.MassMatrix(q, kLump)) * ToVector(ddq) +
                        ToVector(arm.Coriolis(q, dq, kLump)) +
                        ToVector(arm.Gravity(q, kLump, kTilted));
    EXPECT_THAT(arm.InverseDynamics(q, dq, ddq, kLump, kTilted), Pointwise(DoubleNear(1e-12), sum))
        << "sample " << i;
  }
}

TEST(ArmModelDynamicsTest, GravityActsAlongMinusZByDefault) {
  const ArmModel& arm = ArmModel::Panda();
  const auto [q, dq, ddq] = SampleOf(0);
  const Vector3 down{0, 0, -9.81};
  EXPECT_EQ(arm.Gravity(q, kHand), arm.Gravity(q, kHand, down));
  EXPECT_EQ(arm.InverseDynamics(q, dq, ddq, kHand), arm.InverseDynamics(q, dq, ddq, kHand, down));
}

// Energy: with no torque but inertia's, dq^T (dM/dt - 2 C) dq = 0.
TEST(ArmModelDynamicsTest, CoriolisTorqueConservesEnergy) {
  constexpr double kStep = 1e-5;
  const ArmModel& arm = ArmModel::Panda();
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto [q, dq, ddq] = SampleOf(i);
    const Matrix7 dM = (ToMatrix(arm.MassMatrix(Moved(q, dq, kStep), kLump)) -
                        ToMatrix(arm.MassMatrix(Moved(q, dq, -kStep), kLump))) /
                       (2 * kStep);
    const Vector7 v = ToVector(dq);
    const double power = v.dot(ToVector(arm.Coriolis(q, dq, kLump)));
    EXPECT_NEAR(v.dot(dM * v), 2 * power, 1e-7) << "sample " << i;
  }
}

// The whole vector, not only its power: Lagrange's c = (dM/dt) dq - grad(dq^T M dq) / 2.
TEST(ArmModelDynamicsTest, CoriolisTorqueIsThatOfLagrange) {
  constexpr double kStep = 1e-5;
  const ArmModel& arm = ArmModel::Panda();
  const auto derivative = [&](const JointVector& q, const JointVector& along) -> Matrix7 {
    return (ToMatrix(arm.MassMatrix(Moved(q, along, kStep), kLump)) -
            ToMatrix(arm.MassMatrix(Moved(q, along, -kStep), kLump))) /
           (2 * kStep);
  };
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto [q, dq, ddq] = SampleOf(i);
    const Vector7 v = ToVector(dq);
    Vector7 c = derivative(q, dq) * v;
    for (std::size_t j = 0; j < kJoints; ++j) {
      JointVector unit{};
      unit[j] = 1;
      c[static_cast<Eigen::Index>(j)] -= 0.5 * v.dot(derivative(q, unit) * v);
    }
    EXPECT_THAT(arm.Coriolis(q, dq, kLump), Pointwise(DoubleNear(1e-7), c)) << "sample " << i;
  }
}

// Gravity is a potential's: its derivative is symmetric.
TEST(ArmModelDynamicsTest, GravityTorqueIsAGradient) {
  constexpr double kStep = 1e-5;
  const ArmModel& arm = ArmModel::Panda();
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    Matrix7 slope;
    for (std::size_t j = 0; j < kJoints; ++j) {
      JointVector unit{};
      unit[j] = 1;
      slope.col(static_cast<Eigen::Index>(j)) =
          (ToVector(arm.Gravity(Moved(q, unit, kStep), kLump, kTilted)) -
           ToVector(arm.Gravity(Moved(q, unit, -kStep), kLump, kTilted))) /
          (2 * kStep);
    }
    EXPECT_LT((slope - slope.transpose()).cwiseAbs().maxCoeff(), 1e-7) << "sample " << i;
  }
}

// What a payload adds, from the Jacobian of its centre: J^T diag(m, R I R^T) J and -J_v^T m g.
TEST(ArmModelDynamicsTest, PayloadAddsTheInertiaItsJacobianSays) {
  const ArmModel& arm = ArmModel::Panda();
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    const Matrix67 J = CentreJacobian(arm, q, kLump);
    const Eigen::Matrix3d R = FlangeRotation(arm, q);
    Eigen::Matrix<double, 6, 6> inertia = Eigen::Matrix<double, 6, 6>::Zero();
    inertia.topLeftCorner<3, 3>() = kLump.m * Eigen::Matrix3d::Identity();
    inertia.bottomRightCorner<3, 3>() =
        R * Eigen::Map<const Eigen::Matrix3d>(kLump.I.data()) * R.transpose();
    const Matrix7 added = ToMatrix(arm.MassMatrix(q, kLump)) - ToMatrix(arm.MassMatrix(q, {}));
    EXPECT_LT((added - J.transpose() * inertia * J).cwiseAbs().maxCoeff(), 1e-13) << "sample " << i;
  }
}

TEST(ArmModelDynamicsTest, PayloadAddsTheWeightItsJacobianSays) {
  const ArmModel& arm = ArmModel::Panda();
  const Eigen::Vector3d g = Eigen::Map<const Eigen::Vector3d>(kTilted.data());
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    const Matrix67 J = CentreJacobian(arm, q, kLump);
    const Vector7 added =
        ToVector(arm.Gravity(q, kLump, kTilted)) - ToVector(arm.Gravity(q, {}, kTilted));
    const Vector7 expected = -kLump.m * J.topRows<3>().transpose() * g;
    EXPECT_LT((added - expected).cwiseAbs().maxCoeff(), 1e-12) << "sample " << i;
  }
}

TEST(ArmModelDynamicsTest, OnlyTheSymmetricPartOfThePayloadsInertiaCounts) {
  Payload skewed = kLump;
  skewed.I[1] += 0.01;
  skewed.I[3] -= 0.01;
  skewed.I[5] += 0.02;
  skewed.I[7] -= 0.02;
  skewed.I[2] -= 0.03;
  skewed.I[6] += 0.03;
  const JointVector q = SampleOf(0).q;
  EXPECT_THAT(ArmModel::Panda().MassMatrix(q, skewed),
              Pointwise(DoubleNear(1e-15), ArmModel::Panda().MassMatrix(q, kLump)));
}

TEST(ArmModelDynamicsTest, TakesNoMemory) {
  const ArmModel& arm = ArmModel::Panda();
  const Sample sample = SampleOf(0);
  double sum = 0;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    const Payload payload = Combine(kHand, kLump);
    const Configuration q(sample.q);
    sum += arm.MassMatrix(q, payload)[0];
    sum += arm.Coriolis(q, sample.dq, payload)[0];
    sum += arm.Gravity(q, payload)[1];
    sum += arm.InverseDynamics(q, sample.dq, sample.ddq, payload)[0];
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace twin::model::arm_model_dynamics_test
