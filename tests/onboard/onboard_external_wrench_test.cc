#include "twin/onboard/external_wrench.h"

#include <limits>

#include <gtest/gtest.h>
#include <Eigen/SVD>

#include "onboard/arm_samples.h"
#include "support/dense.h"
#include "support/realtime_guard.h"
#include "twin/onboard/sensing.h"

namespace twin::onboard::onboard_external_wrench_test {
namespace {

constexpr double kGainMax = 30;
constexpr Vector6 kWrench{12, -20, 7, 1.5, -0.8, 2.2};  // base axes, at K

/// The estimate for K in EE.
ExternalWrench Estimate(const JointVector& tau, const JointVector& q,
                        const Transform& EE_T_K = kIdentityTransform, double gain = kGainMax) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  return EstimateWrench(tau, arm.ZeroJacobian(model::Frame::kEndEffector, q, model::kHandPose),
                        arm.Pose(model::Frame::kEndEffector, q, model::kHandPose), EE_T_K, gain);
}

TEST(ExternalWrenchTest, FindsTheWrenchAtKThatMadeTheTorque) {
  for (std::uint64_t pose = 0; pose < 50; ++pose) {
    const JointVector q = RegularPose(pose);
    for (const Transform& EE_T_K : {kIdentityTransform, kTiltedK}) {
      const ExternalWrench found = Estimate(TorqueOf(kWrench, q, EE_T_K), q, EE_T_K);
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(found.O_F_ext_hat_K[k], kWrench[k], 1e-9) << "pose " << pose;
      }
    }
  }
}

TEST(ExternalWrenchTest, ShowsItInTheAxesOfKToo) {
  const JointVector q = RegularPose(3);
  const ExternalWrench found = Estimate(TorqueOf(kWrench, q, kTiltedK), q, kTiltedK);
  const Transform O_T_K = model::ArmModel::Panda().Pose(
      model::Frame::kEndEffector, q, model::Multiply(model::kHandPose, kTiltedK));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double force = 0;
    double moment = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      force += O_T_K[4 * axis + k] * kWrench[k];
      moment += O_T_K[4 * axis + k] * kWrench[3 + k];
    }
    EXPECT_NEAR(found.K_F_ext_hat_K[axis], force, 1e-9);
    EXPECT_NEAR(found.K_F_ext_hat_K[3 + axis], moment, 1e-9);
  }
}

TEST(ExternalWrenchTest, IsThePseudoinverseWhenNoWrenchAtKExplainsTheTorque) {
  const JointVector tau{4, -3, 2, 5, -1, 0.7, 1.1};
  for (std::uint64_t pose = 0; pose < 20; ++pose) {
    const JointVector q = RegularPose(pose);
    for (const Transform& EE_T_K : {kIdentityTransform, kTiltedK}) {
      const Eigen::VectorXd expected =
          test::LeastSquares(JacobianOf(q, EE_T_K).transpose(),
                             Eigen::Map<const Eigen::Matrix<double, kJoints, 1>>(tau.data()));
      const ExternalWrench found = Estimate(tau, q, EE_T_K);
      for (int k = 0; k < 6; ++k) {
        EXPECT_NEAR(found.O_F_ext_hat_K[static_cast<std::size_t>(k)], expected[k], 1e-8);
      }
    }
  }
}

TEST(ExternalWrenchTest, IsZeroFromTheBoundOnWhereErrorsWouldGrow) {
  // The bound is on sqrt(sum 1/sigma^2), recomputed here by a singular value decomposition.
  int singular = 0;
  for (std::uint64_t index = 0; index < 300; ++index) {
    const JointVector q = model::SampleOf(index).q;
    const double gain = WrenchGain(q);
    const JointVector tau = TorqueOf(kWrench, q);
    EXPECT_NE(Estimate(tau, q, kIdentityTransform, gain * 1.0001).O_F_ext_hat_K, Vector6{});
    const ExternalWrench beyond = Estimate(tau, q, kIdentityTransform, gain * 0.9999);
    EXPECT_EQ(beyond.O_F_ext_hat_K, Vector6{});
    EXPECT_EQ(beyond.K_F_ext_hat_K, Vector6{});
    if (gain > kGainMax) ++singular;
  }
  EXPECT_GT(singular, 30);
  EXPECT_LT(singular, 100);
}

TEST(ExternalWrenchTest, IsZeroWhereTheArmIsStretchedOut) {
  for (const double q4 : {-0.4670024, -0.45, -0.5}) {
    JointVector q = model::kReady;
    q[3] = q4;
    EXPECT_EQ(Estimate({1, 1, 1, 1, 1, 1, 1}, q).O_F_ext_hat_K, Vector6{}) << q4;
  }
  EXPECT_NE(Estimate({1, 1, 1, 1, 1, 1, 1}, model::kReady).O_F_ext_hat_K, Vector6{});
}

TEST(ExternalWrenchTest, MakesNoReflexOfWhatFrictionLeaves) {
  const double lowest = 20;  // N, of the thresholds with which the robot starts
  for (std::uint64_t index = 0; index < 300; ++index) {
    const JointVector q = model::SampleOf(index).q;
    // The worst of all torques of 1 Nm.
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(JacobianOf(q, kIdentityTransform),
                                                Eigen::ComputeThinV);
    JointVector tau;
    Eigen::Map<Eigen::VectorXd>(tau.data(), kJoints) = svd.matrixV().col(5);
    const ExternalWrench found =
        Estimate(tau, q, kIdentityTransform, SensingConfig().wrench_gain_max);
    EXPECT_LT(HalfNorm(found.O_F_ext_hat_K, 0), lowest) << "pose " << index;
  }
}

TEST(ExternalWrenchTest, ExactlySingularAndNotFiniteGiveZero) {
  const Transform O_T_EE = kIdentityTransform;
  model::Jacobian J{};
  EXPECT_EQ(EstimateWrench({1, 1, 1, 1, 1, 1, 1}, J, O_T_EE, kIdentityTransform, 1e6).O_F_ext_hat_K,
            Vector6{});
  J.fill(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(EstimateWrench({1, 1, 1, 1, 1, 1, 1}, J, O_T_EE, kIdentityTransform, 1e6).O_F_ext_hat_K,
            Vector6{});
}

TEST(ExternalWrenchTest, TakesNoMemory) {
  const JointVector q = RegularPose(1);
  const JointVector tau = TorqueOf(kWrench, q);
  const test::RealtimeGuard guard;
  double sum = 0;
  for (int k = 0; k < 1000; ++k) sum += Estimate(tau, q, kTiltedK).K_F_ext_hat_K[0];
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_NE(sum, 0);
}

}  // namespace
}  // namespace twin::onboard::onboard_external_wrench_test
