#include "twin/reference/feed_forward.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::reference::reference_pose_feed_forward_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

void ExpectTwist(const Vector6& twist, const Vector6& expected, double tolerance) {
  for (std::size_t i = 0; i < twist.size(); ++i) {
    EXPECT_NEAR(twist[i], expected[i], tolerance) << "component " << i;
  }
}

TEST(PoseFeedForwardTest, RefusesANominalPeriodThatIsNotPositive) {
  for (const Duration period : {0ns, -1ns}) {
    EXPECT_THAT([&] { PoseFeedForward forward(FeedForwardTime::kNominal, period); },
                ThrowsMessage<InputError>(HasSubstr("nominal period is")));
  }
}

TEST(PoseFeedForwardTest, GivesNoTwistBeforeTheSecondDeposit) {
  PoseFeedForward forward;
  const Transform X = PoseOf({1, 0, 0}, {1, 2, 3});
  const PoseTarget first = forward.Next(Time(5ms), X);
  EXPECT_EQ(first.O_T_EE, X);
  EXPECT_EQ(first.O_dP_EE, Vector6{});
  EXPECT_NE(forward.Next(Time(6ms), kIdentityTransform).O_dP_EE, Vector6{});
  forward.Reset();
  EXPECT_EQ(forward.Next(Time(7ms), X).O_dP_EE, Vector6{});
}

TEST(PoseFeedForwardTest, DividesByTheSourcesOwnTime) {
  PoseFeedForward forward;
  const Transform start = PoseOf({0.4, -1, 0.2}, {0.1, 0.2, 0.3});
  (void)forward.Next(Time(0ms), start);
  Transform X = PoseOf({0.004, -0.002, 0.008}, {0.104, 0.192, 0.3});
  Eigen::Map<Eigen::Matrix4d>(X.data()).topLeftCorner<3, 3>() = RotationOf(X) * RotationOf(start);
  ExpectTwist(forward.Next(Time(4ms), X).O_dP_EE, {1, -2, 0, 1, -0.5, 2}, 1e-12);
}

TEST(PoseFeedForwardTest, DividesByTheNominalPeriodWhenTold) {
  PoseFeedForward forward(FeedForwardTime::kNominal, 2ms);
  (void)forward.Next(Time(0ms), kIdentityTransform);
  ExpectTwist(forward.Next(Time(5ms), PoseOf({0, 0, 0.002}, {0.004, 0, 0})).O_dP_EE,
              {2, 0, 0, 0, 0, 1}, 1e-12);
}

TEST(PoseFeedForwardTest, KeepsTheTwistWhenTimeDoesNotRise) {
  for (const auto time : {FeedForwardTime::kSource, FeedForwardTime::kNominal}) {
    PoseFeedForward forward(time);
    (void)forward.Next(Time(0ms), kIdentityTransform);
    const Vector6 twist = forward.Next(Time(1ms), PoseOf({0, 0.001, 0}, {0.001, 0, 0})).O_dP_EE;
    ExpectTwist(twist, {1, 0, 0, 0, 1, 0}, 1e-12);
    const Transform elsewhere = PoseOf({0, 0.5, 0}, {0.5, 0, 0});
    EXPECT_EQ(forward.Next(Time(1ms), elsewhere).O_dP_EE, twist);
    EXPECT_EQ(forward.Next(Time(0ms), elsewhere).O_dP_EE, twist);
    // A source whose clock was set back goes on from its new time.
    ExpectTwist(forward.Next(Time(1ms), PoseOf({0, 0.502, 0}, {0.503, 0, 0})).O_dP_EE,
                {3, 0, 0, 0, 2, 0}, 1e-12);
  }
}

TEST(PoseFeedForwardTest, ASteadyTurnHasASteadyTwistThroughManyTurns) {
  const Vector3d axis = Vector3d(1, -2, 2) / 3;
  PoseFeedForward forward;
  (void)forward.Next(Time(), kIdentityTransform);
  for (int k = 1; k <= 20'000; ++k) {
    const Vector6 twist = forward.Next(Time(k * 1ms), PoseOf(2e-3 * k * axis, {0, 0, 0})).O_dP_EE;
    for (std::size_t i = 0; i < 3; ++i) ASSERT_NEAR(twist[3 + i], 2 * axis[i], 1e-10) << k;
  }
}

/// Worst error of the angular velocity of a turn by sin(2 t) about z, sampled every ms with jitter,
/// against the true one in the middle of each interval.
double WorstError(FeedForwardTime time, double jitter_s) {
  const Random random(1, RandomStream::kTest);
  PoseFeedForward forward(time, kCycle);
  double last_s = 0;
  double worst = 0;
  for (std::uint64_t k = 1; k <= 4000; ++k) {
    const double wanted_s = kCycleSeconds * static_cast<double>(k);
    const Time at(FromSeconds(wanted_s + jitter_s * (2 * random.Uniform(k) - 1)));
    const double at_s = ToSeconds(at.time_since_epoch());
    const PoseTarget target = forward.Next(at, PoseOf({0, 0, std::sin(2 * at_s)}, {0, 0, 0}));
    if (k > 1) {
      worst = std::max(worst, std::abs(target.O_dP_EE[5] - 2 * std::cos(at_s + last_s)));
    }
    last_s = at_s;
  }
  return worst;
}

TEST(PoseFeedForwardTest, SourceTimeMakesTheMeanTwistRightToFirstOrderUnderJitter) {
  // Mean value against middle: third derivative <= 8, times h^2 / 24 with h <= 1.4 ms.
  EXPECT_LT(WorstError(FeedForwardTime::kSource, 0.2e-3), 8 * 1.4e-3 * 1.4e-3 / 24 * 1.01);
}

TEST(PoseFeedForwardTest, NominalTimePassesTheJitterThrough) {
  // The error is the velocity times the relative deviation of the interval: up to 2 rad/s x 0.4.
  const double worst = WorstError(FeedForwardTime::kNominal, 0.2e-3);
  EXPECT_GT(worst, 0.5);
  EXPECT_LT(worst, 0.8 * 1.01);
}

TEST(PoseFeedForwardTest, AllocatesNothing) {
  const Random random(2, RandomStream::kTest);
  PoseFeedForward forward;
  PoseTarget target;
  const test::RealtimeGuard guard;
  for (int k = 0; k < 10'000; ++k) {
    target = forward.Next(Time(k * 1ms), RandomPose(random, static_cast<std::uint64_t>(k)));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(target.O_dP_EE, Vector6{});
}

}  // namespace
}  // namespace twin::reference::reference_pose_feed_forward_test
