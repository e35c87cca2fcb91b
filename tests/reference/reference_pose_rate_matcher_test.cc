#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/reference/rate_matcher.h"

namespace twin::reference::reference_pose_rate_matcher_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

const Vector3d kAxis = Vector3d(2, -1, 2) / 3;

PoseTarget TurnedBy(double angle) {
  return {PoseOf(angle * kAxis, {0, 0, 0}), {}};
}

PoseTarget RandomTarget(const Random& random, std::uint64_t tick) {
  PoseTarget u{RandomPose(random, tick), {}};
  for (std::uint32_t i = 0; i < 6; ++i) u.O_dP_EE[i] = random.Normal(tick, 20 + i);
  return u;
}

TEST(PoseRateMatcherTest, HasTheWindowAndTheRangeOfAnyRateMatcher) {
  EXPECT_EQ(PoseRateMatcher(1000).window(), 1u);
  EXPECT_EQ(PoseRateMatcher(1000.0 / 3).window(), 3u);
  EXPECT_EQ(PoseRateMatcher(125).window(), 8u);
  for (const double rate : {0.5, 1000.1, std::nan("")}) {
    EXPECT_THAT([&] { PoseRateMatcher matcher(rate); },
                ThrowsMessage<InputError>(HasSubstr("it must lie in [1, 1000]")));
  }
}

TEST(PoseRateMatcherTest, StartsAtTheIdentityWithoutAReset) {
  const PoseTarget y = PoseRateMatcher(500).Next(TurnedBy(0.1));
  EXPECT_LT((RotationVector(kIdentityTransform, y.O_T_EE) - 0.05 * kAxis).norm(), 1e-15);
}

TEST(PoseRateMatcherTest, PassesEverythingThroughAtTheCycleRate) {
  const Random random(1, RandomStream::kTest);
  PoseRateMatcher matcher(1000);
  for (std::uint64_t k = 0; k < 50; ++k) {
    const PoseTarget u = RandomTarget(random, k);
    const PoseTarget y = matcher.Next(u);
    EXPECT_EQ(y.O_T_EE, u.O_T_EE);
    EXPECT_EQ(y.O_dP_EE, u.O_dP_EE);
  }
}

TEST(PoseRateMatcherTest, AveragesPositionAndTwistAsJointsAre) {
  const Random random(2, RandomStream::kTest);
  PoseRateMatcher poses(125);
  RateMatcher joints(125);
  for (std::uint64_t k = 0; k < 500; ++k) {
    const PoseTarget u = RandomTarget(random, k / 5);
    JointTarget same;
    std::copy_n(u.O_T_EE.begin() + 12, 3, same.q.begin());
    std::copy_n(u.O_dP_EE.begin(), 6, same.dq.begin());
    const PoseTarget y = poses.Next(u);
    const JointTarget expected = joints.Next(same);
    for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(y.O_T_EE[12 + i], expected.q[i]);
    for (std::size_t i = 0; i < 6; ++i) ASSERT_EQ(y.O_dP_EE[i], expected.dq[i]);
  }
}

/// Largest deviation of an increment from h/N, over many turns of a staircase of steps h at N = 8;
/// and the largest deviation of its axis.
double WorstIncrementError(double h) {
  PoseRateMatcher matcher(125);
  Transform last = kIdentityTransform;
  double worst = 0;
  const auto cycles = static_cast<int>(8 * 20 / h);
  for (int k = 0; k < cycles; ++k) {
    const int deposits = 1 + k / 8;
    const Transform y = matcher.Next(TurnedBy(h * deposits)).O_T_EE;
    worst = std::max(worst, (RotationVector(last, y) - h / 8 * kAxis).norm());
    last = y;
  }
  return worst;
}

TEST(PoseRateMatcherTest, TurnsAStaircaseIntoARampOfEqualTurns) {
  // With x = m/N of the way, the mean of quaternions an angle d = h/2 apart points to
  // x d - d^3 x (1 - x)(1 - 2x)/6 + O(d^5); the increments' error follows, at its largest from x =
  // 0 to 1/8.
  const auto error = [](double h) { return 2 * std::pow(h / 2, 3) * (7.0 / 64) * (3.0 / 4) / 6; };
  EXPECT_NEAR(WorstIncrementError(0.2) / error(0.2), 1, 0.01);
  EXPECT_NEAR(WorstIncrementError(0.1) / error(0.1), 1, 0.01);
  EXPECT_NEAR(WorstIncrementError(0.05) / error(0.05), 1, 0.01);
  // A step of the Panda's full speed, 8 ms at 2.5 rad/s.
  EXPECT_LT(WorstIncrementError(0.02), 3e-8);
}

TEST(PoseRateMatcherTest, DelaysASteadyTurnByHalfTheWindow) {
  for (const double rate : {500.0, 125.0, 20.0}) {
    PoseRateMatcher matcher(rate);
    const auto n = static_cast<double>(matcher.window());
    for (int k = 0; k < 10'000; ++k) {
      const Transform y = matcher.Next(TurnedBy(2e-3 * k)).O_T_EE;
      if (k < n) continue;
      const Transform expected = TurnedBy(2e-3 * (k - (n - 1) / 2)).O_T_EE;
      ASSERT_LT(RotationVector(y, expected).norm(), 1e-12) << "cycle " << k;
    }
  }
}

TEST(PoseRateMatcherTest, StaysOrthonormal) {
  const Random random(3, RandomStream::kTest);
  PoseRateMatcher matcher(125);
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    const Transform y = matcher.Next(RandomTarget(random, k / 8)).O_T_EE;
    ASSERT_LT(Obliqueness(y), 1e-14);
    ASSERT_EQ((std::array{y[3], y[7], y[11], y[15]}), (std::array{0.0, 0.0, 0.0, 1.0}));
  }
}

TEST(PoseRateMatcherTest, StartsAtTheResetValueWithoutAStep) {
  PoseRateMatcher matcher(125);
  const PoseTarget u0 = RandomTarget(Random(4, RandomStream::kTest), 0);
  matcher.Reset(u0);
  EXPECT_EQ(matcher.Next(u0).O_T_EE, u0.O_T_EE);
  PoseTarget moved = u0;
  moved.O_T_EE[12] += 0.8;
  moved.O_dP_EE[5] += 1.6;
  const PoseTarget y = matcher.Next(moved);
  EXPECT_NEAR(y.O_T_EE[12], u0.O_T_EE[12] + 0.1, 1e-15);
  EXPECT_NEAR(y.O_dP_EE[5], u0.O_dP_EE[5] + 0.2, 1e-15);
}

TEST(PoseRateMatcherTest, GivesAStalledPoseExactlyAfterTheWindow) {
  const Random random(5, RandomStream::kTest);
  PoseRateMatcher matcher(125);
  for (std::uint64_t k = 0; k < 1000; ++k) (void)matcher.Next(RandomTarget(random, k));
  const PoseTarget last = RandomTarget(random, 1000);
  for (int k = 0; k < 7; ++k) EXPECT_NE(matcher.Next(last).O_T_EE, last.O_T_EE);
  for (int k = 7; k < 40; ++k) {
    const PoseTarget y = matcher.Next(last);
    EXPECT_EQ(y.O_T_EE, last.O_T_EE);
    EXPECT_EQ(y.O_dP_EE, last.O_dP_EE);
  }
}

TEST(PoseRateMatcherTest, HalfATurnInOneStepIsAveragedToSomewhereBetween) {
  PoseRateMatcher matcher(125);
  matcher.Reset(TurnedBy(0));
  const double wish = std::numbers::pi * (1 - 1e-9);
  double last = 0;
  for (int k = 0; k < 8; ++k) {
    const double angle =
        RotationVector(kIdentityTransform, matcher.Next(TurnedBy(wish)).O_T_EE).norm();
    EXPECT_GT(angle, last + 0.1);
    last = angle;
  }
  EXPECT_NEAR(last, wish, 1e-12);
}

TEST(PoseRateMatcherTest, TurnsThatCancelOutGiveTheNewest) {
  // Four quarters of a turn: the quaternions go round once in eight steps.
  PoseRateMatcher matcher(125);
  for (int k = 0; k < 100; ++k) {
    const PoseTarget u = TurnedBy(std::numbers::pi / 2 * k);
    const Transform y = matcher.Next(u).O_T_EE;
    ASSERT_LT(Obliqueness(y), 1e-14);
    if (k >= 8) {
      ASSERT_EQ(y, u.O_T_EE);
    }
  }
}

TEST(PoseRateMatcherTest, ForgetsAPoseThatIsNotFinite) {
  const Random random(6, RandomStream::kTest);
  for (std::uint64_t at = 0; at < 8; ++at) {
    PoseRateMatcher matcher(125);
    PoseTarget y;
    for (std::uint64_t k = 0; k <= at + 16; ++k) {
      PoseTarget u = RandomTarget(random, k);
      if (k == at) u.O_T_EE.fill(std::numeric_limits<double>::quiet_NaN());
      y = matcher.Next(u);
      if (k == at) {
        EXPECT_TRUE(std::isnan(y.O_T_EE[0]) && std::isnan(y.O_T_EE[12]));
      }
    }
    for (const double value : y.O_T_EE) EXPECT_TRUE(std::isfinite(value)) << "deposited at " << at;
    EXPECT_LT(Obliqueness(y.O_T_EE), 1e-14);
  }
}

TEST(PoseRateMatcherTest, AllocatesNothing) {
  const Random random(7, RandomStream::kTest);
  PoseRateMatcher matcher(10);
  PoseTarget y;
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    if (k % 1000 == 0) matcher.Reset(RandomTarget(random, k));
    y = matcher.Next(RandomTarget(random, k));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(y.O_T_EE, kIdentityTransform);
}

}  // namespace
}  // namespace twin::reference::reference_pose_rate_matcher_test
