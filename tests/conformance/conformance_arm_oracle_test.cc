// The arm that the checkers of INT reckon with: against data, against sampling, and against INT's.

#include <cmath>

#include <gtest/gtest.h>

#include "conformance/arm_oracle.h"
#include "conformance/dice.h"
#include "model/model_reference.h"
#include "support/panda_limits.h"
#include "twin/model/self_collision.h"

namespace twin::test::conformance_arm_oracle_test {
namespace {

JointVector Anywhere(Dice& dice) {
  const JointLimits limits = PandaLimits();
  JointVector q{};
  for (std::size_t i = 0; i < kJoints; ++i) q[i] = dice.Between(limits.q_min[i], limits.q_max[i]);
  return q;
}

TEST(ArmOracleTest, PoseOfTheFlangeIsThatOfTheData) {
  model::ModelReference().ExpectEverySample(
      "O_T_F", [](const JointVector& q, const JointVector&, const model::Payload&) {
        return ArmOracle(q).Pose();
      });
}

TEST(ArmOracleTest, JacobianIsThatOfTheData) {
  model::ModelReference().ExpectEverySample(
      "O_J_F", [](const JointVector& q, const JointVector&, const model::Payload&) {
        std::array<double, 6 * kJoints> flat{};
        const std::array<Vector6, kJoints> J = ArmOracle(q).Jacobian();
        for (std::size_t i = 0; i < kJoints; ++i) {
          for (std::size_t r = 0; r < 6; ++r) flat[6 * i + r] = J[i][r];
        }
        return flat;
      });
}

TEST(ArmOracleTest, GravityIsThatOfTheData) {
  model::ModelReference().ExpectEverySample(
      "g", [](const JointVector& q, const JointVector&, const model::Payload& payload) {
        return ArmOracle(q).Gravity({{payload.m, payload.F_x_C}});
      });
}

// FCI protocol 5, kinematics: the ready pose with a hand.
TEST(ArmOracleTest, TheReadyPoseIsThePublishedOne) {
  Transform F_T_EE = kIdentityTransform;
  F_T_EE[14] = 0.1034;
  const double pi = std::acos(-1.0);
  const Transform X = ArmOracle({0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4}).Pose(F_T_EE);
  EXPECT_NEAR(X[12], 0.3069, 5e-5);
  EXPECT_NEAR(X[13], 0, 5e-5);
  EXPECT_NEAR(X[14], 0.4869, 5e-5);
}

TEST(ArmOracleTest, DistancesAreThoseOfPointsOnTheParts) {
  Dice dice(5);
  for (int k = 0; k < 100; ++k) {
    constexpr double kSpacing = 2e-3;
    const ArmOracle arm(Anywhere(dice));
    const bool with_hand = dice.Chance(0.7);
    const double sampled = arm.SampledSelfDistance(with_hand, kSpacing);
    EXPECT_LE(arm.SelfDistance(with_hand), sampled + 1e-12) << k;
    EXPECT_GE(arm.SelfDistance(with_hand), sampled - kSpacing) << k;
  }
}

TEST(ArmOracleTest, IntKnowsTheSameDistances) {
  Dice dice(6);
  for (int k = 0; k < 10000; ++k) {
    const JointVector q = Anywhere(dice);
    const bool with_hand = dice.Chance(0.7);
    ASSERT_NEAR(model::SelfDistance(model::Configuration(q), with_hand),
                ArmOracle(q).SelfDistance(with_hand), 1e-9)
        << k;
  }
}

}  // namespace
}  // namespace twin::test::conformance_arm_oracle_test
