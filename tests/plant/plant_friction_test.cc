#include "plant/joint_parameters.h"

#include <gtest/gtest.h>

namespace twin::plant::plant_friction_test {
namespace {

JointVector All(double value) {
  JointVector v{};
  v.fill(value);
  return v;
}

TEST(ResidualFrictionTest, IsZeroAtRest) {
  EXPECT_EQ(ResidualFriction(All(0)), All(0));
}

TEST(ResidualFrictionTest, OpposesMotionAndGrowsWithSpeed) {
  JointVector slower = ResidualFriction(All(-3));
  for (int k = -299; k <= 300; ++k) {
    const double dq = 0.01 * k;
    const JointVector tau = ResidualFriction(All(dq));
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_GE(tau[i] * dq, 0) << "joint " << i + 1 << " at " << dq;
      EXPECT_GE(tau[i], slower[i]) << "joint " << i + 1 << " at " << dq;
    }
    slower = tau;
  }
}

// Between far forward and far backward the sigmoid rises by its height phi1.
TEST(ResidualFrictionTest, SpansPhi1) {
  const JointVector phi1{0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489};
  const JointVector forward = ResidualFriction(All(50));
  const JointVector backward = ResidualFriction(All(-50));
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(forward[i] - backward[i], phi1[i], 1e-12);
}

}  // namespace
}  // namespace twin::plant::plant_friction_test
