#include "twin/onboard/joint_reference.h"

#include <cmath>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/core/random.h"

namespace twin::onboard::onboard_stop_profile_test {
namespace {

constexpr double kTolerance = 1 + 1e-9;

/// Cycles until rest; fails the test when a limit is broken on the way.
int CyclesToRest(JointReference reference, const JointLimits& limits, int most) {
  for (int cycle = 0; cycle < most; ++cycle) {
    if (reference.AtRest()) return cycle;
    reference = StopStep(reference, limits);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_LE(std::abs(reference.ddq_d[i]), limits.ddq_max[i] * kTolerance);
      EXPECT_LE(std::abs(reference.dddq_d[i]), limits.dddq_max[i] * kTolerance);
    }
  }
  return most;
}

TEST(StopProfileTest, StopsFromFullSpeedAsFastAsTheLimitsAllow) {
  // Joint 2: 2.175 rad/s at 7.5 rad/s^2 is 290 cycles; the acceleration builds up and falls in
  // steps of half of it, so 289 cycles at the full value, one at half before and after, and one in
  // which it returns to zero.
  JointReference reference;
  reference.dq_d[1] = 2.175;
  EXPECT_EQ(CyclesToRest(reference, test::PandaLimits(), 1000), 292);
}

TEST(StopProfileTest, LeavesARestingReferenceWhereItIs) {
  const JointReference rest = JointReference::Rest({0.1, 0.2, 0.3, -1, 0.5, 0.6, 0.7});
  const JointReference next = StopStep(rest, test::PandaLimits());
  EXPECT_EQ(next.q_d, rest.q_d);
  EXPECT_TRUE(next.AtRest());
}

/// Stops from random states inside the limits.
void ExpectRestWithin(int most_cycles, const JointLimits& limits, std::uint64_t trials) {
  const Random random(7, RandomStream::kTest);
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    JointReference reference;
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      reference.dq_d[i] = limits.dq_max[i] * (2 * random.Uniform(trial, 2 * i) - 1);
      reference.ddq_d[i] = limits.ddq_max[i] * (2 * random.Uniform(trial, 2 * i + 1) - 1);
    }
    ASSERT_LT(CyclesToRest(reference, limits, most_cycles), most_cycles) << "trial " << trial;
  }
}

TEST(StopProfileTest, ReachesRestFromEveryLegalState) {
  ExpectRestWithin(600, test::PandaLimits(), 2000);
}

TEST(StopProfileTest, ReachesRestUnderSlowJerkToo) {
  // A jerk limit at which the acceleration takes 50 cycles to build up.
  JointLimits limits = test::PandaLimits();
  for (std::size_t i = 0; i < kJoints; ++i) limits.dddq_max[i] = limits.ddq_max[i] / 0.05;
  ExpectRestWithin(900, limits, 500);
}

TEST(StopProfileTest, NeverTurnsBackWhenItStartsWithoutAcceleration) {
  JointReference reference;
  reference.dq_d.fill(1.0);
  const JointLimits limits = test::PandaLimits();
  while (!reference.AtRest()) {
    reference = StopStep(reference, limits);
    for (const double dq : reference.dq_d) ASSERT_GE(dq, -1e-12);
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_stop_profile_test
