#include "twin/onboard/friction_compensation.h"

#include <cmath>

#include <gtest/gtest.h>

namespace twin::onboard::onboard_friction_compensation_test {
namespace {

constexpr JointVector kTau{1, -2, 3, -4, 5, -6, 7};
constexpr JointVector kDq{0.5, -0.5, 0.01, -0.01, 2, -2, 0.1};

TEST(FrictionCompensationTest, AddsNotEvenAZeroWhenItsShareIsZero) {
  JointVector tau{-0.0, -0.0, 0.0, 1, 2, 3, 4};
  FrictionCompensation(0).AddTo(tau, kDq);
  EXPECT_TRUE(std::signbit(tau[0])) << "-0.0 + 0.0 would be +0.0";
  EXPECT_EQ(tau[3], 1);
}

TEST(FrictionCompensationTest, AddsItsShareOfTheResidual) {
  // Joint 1 by hand from the published figures: 0.54615, 5.1181, 0.039533.
  const double tau_f = 0.54615 / (1 + std::exp(-5.1181 * (0.5 + 0.039533))) -
                       0.54615 / (1 + std::exp(-5.1181 * 0.039533));
  for (const double share : {0.25, 0.5, 1.0}) {
    JointVector tau = kTau;
    FrictionCompensation(share).AddTo(tau, kDq);
    EXPECT_NEAR(tau[0], kTau[0] + share * tau_f, 1e-15);
    const JointVector all = model::ResidualFriction(kDq);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(tau[i], kTau[i] + share * all[i], 1e-15);
    }
  }
}

TEST(FrictionCompensationTest, HelpsAlongTheMotionAndDoesNothingAtRest) {
  JointVector tau{};
  FrictionCompensation(1).AddTo(tau, kDq);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_GT(tau[i] * kDq[i], 0);
  JointVector resting{};
  FrictionCompensation(1).AddTo(resting, JointVector{});
  EXPECT_EQ(resting, JointVector{});
}

TEST(FrictionCompensationTest, IsSmoothThroughRest) {
  // phi1 phi2 / 4 is the steepest slope of a sigmoid: 2.0 Nm s/rad for the steepest joint.
  for (double dq = -0.2; dq < 0.2; dq += 1e-3) {
    JointVector before{};
    JointVector after{};
    JointVector v{};
    v.fill(dq);
    FrictionCompensation(1).AddTo(before, v);
    v.fill(dq + 1e-3);
    FrictionCompensation(1).AddTo(after, v);
    for (std::size_t i = 0; i < kJoints; ++i) EXPECT_LT(after[i] - before[i], 2.1e-3);
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_friction_compensation_test
