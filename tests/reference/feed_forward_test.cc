#include "twin/reference/feed_forward.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <gmock/gmock.h>

#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::reference::feed_forward_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

JointVector Filled(double value) {
  JointVector v;
  v.fill(value);
  return v;
}

TEST(FeedForwardTest, RefusesANominalPeriodThatIsNotPositive) {
  EXPECT_THAT([] { FeedForward forward(FeedForwardTime::kNominal, 0ns); },
              ThrowsMessage<InputError>(HasSubstr("nominal period is 0 ns")));
}

TEST(FeedForwardTest, GivesNoVelocityBeforeTheSecondDeposit) {
  FeedForward forward;
  const JointTarget first = forward.Next(Time(5ms), Filled(0.4));
  EXPECT_EQ(first.q, Filled(0.4));
  EXPECT_EQ(first.dq, JointVector{});
  EXPECT_EQ(first.ddq, JointVector{});
  (void)forward.Next(Time(6ms), Filled(0.5));
  forward.Reset();
  EXPECT_EQ(forward.Next(Time(7ms), Filled(0.9)).dq, JointVector{});
}

TEST(FeedForwardTest, DividesByTheSourcesOwnTime) {
  FeedForward forward;
  (void)forward.Next(Time(0ms), {});
  const JointTarget target = forward.Next(Time(4ms), {0.004, -0.008, 0, 0, 0, 0, 0.012});
  EXPECT_DOUBLE_EQ(target.dq[0], 1);
  EXPECT_DOUBLE_EQ(target.dq[1], -2);
  EXPECT_DOUBLE_EQ(target.dq[6], 3);
}

TEST(FeedForwardTest, KeepsTheVelocityWhenTimeDoesNotRise) {
  for (const auto time : {FeedForwardTime::kSource, FeedForwardTime::kNominal}) {
    FeedForward forward(time);
    (void)forward.Next(Time(0ms), Filled(0));
    (void)forward.Next(Time(1ms), Filled(0.001));
    const JointTarget same = forward.Next(Time(1ms), Filled(0.5));
    EXPECT_EQ(same.q, Filled(0.5));
    EXPECT_DOUBLE_EQ(same.dq[0], 1);
    EXPECT_DOUBLE_EQ(forward.Next(Time(0ms), Filled(0.6)).dq[0], 1);
    // A source whose clock was set back goes on from its new time.
    EXPECT_NEAR(forward.Next(Time(1ms), Filled(0.602)).dq[0], 2, 1e-12);
  }
}

/// Worst error of the velocity of q = sin(2 t), sampled every ms with jitter, against the true one
/// in the middle of each interval.
double WorstError(FeedForwardTime time, double jitter_s) {
  const Random random(1, RandomStream::kTest);
  FeedForward forward(time, kCycle);
  double last_s = 0;
  double worst = 0;
  for (std::uint64_t k = 1; k <= 4000; ++k) {
    const double wanted_s = kCycleSeconds * static_cast<double>(k);
    const Time at(FromSeconds(wanted_s + jitter_s * (2 * random.Uniform(k) - 1)));
    const double at_s = ToSeconds(at.time_since_epoch());
    const JointTarget target = forward.Next(at, Filled(std::sin(2 * at_s)));
    if (k > 1) {
      worst = std::max(worst, std::abs(target.dq[0] - 2 * std::cos(at_s + last_s)));
    }
    last_s = at_s;
  }
  return worst;
}

TEST(FeedForwardTest, SourceTimeMakesTheMeanVelocityRightToFirstOrderUnderJitter) {
  // Mean value against middle: dddq h^2 / 24 with dddq <= 8 and h <= 1.4 ms.
  EXPECT_LT(WorstError(FeedForwardTime::kSource, 0.2e-3), 8 * 1.4e-3 * 1.4e-3 / 24 * 1.01);
}

TEST(FeedForwardTest, NominalTimePassesTheJitterThrough) {
  // The error is dq times the relative deviation of the interval: up to 2 rad/s x 0.4.
  const double worst = WorstError(FeedForwardTime::kNominal, 0.2e-3);
  EXPECT_GT(worst, 0.5);
  EXPECT_LT(worst, 0.8 * 1.01);
  EXPECT_LT(WorstError(FeedForwardTime::kNominal, 0), 1e-5);
}

}  // namespace
}  // namespace twin::reference::feed_forward_test
