#include <cmath>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/reference/rate_matcher.h"

namespace twin::reference::reference_torque_rate_matcher_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

JointVector RandomTorque(const Random& random, std::uint64_t tick) {
  JointVector tau;
  for (std::uint32_t j = 0; j < kJoints; ++j) tau[j] = 87 * (2 * random.Uniform(tick, j) - 1);
  return tau;
}

TEST(TorqueRateMatcherTest, HasTheWindowAndTheRangeOfAnyRateMatcher) {
  EXPECT_EQ(TorqueRateMatcher(1000).window(), 1u);
  EXPECT_EQ(TorqueRateMatcher(400).window(), 3u);
  for (const double rate : {0.5, 1000.1, std::nan("")}) {
    EXPECT_THAT([&] { TorqueRateMatcher matcher(rate); },
                ThrowsMessage<InputError>(HasSubstr("it must lie in [1, 1000]")));
  }
}

TEST(TorqueRateMatcherTest, IsTheMeanOfTheWindow) {
  const Random random(1, RandomStream::kTest);
  for (const double rate : {1000.0, 500.0, 125.0, 30.0}) {
    TorqueRateMatcher matcher(rate);
    const JointVector tau_0 = RandomTorque(random, 999'999);
    matcher.Reset(tau_0);
    const auto n = static_cast<std::int64_t>(matcher.window());
    for (std::int64_t k = 0; k < 300; ++k) {
      const JointVector y = matcher.Next(RandomTorque(random, static_cast<std::uint64_t>(k)));
      for (std::size_t j = 0; j < kJoints; ++j) {
        double sum = 0;
        for (std::int64_t i = k - n + 1; i <= k; ++i) {
          sum += i < 0 ? tau_0[j] : RandomTorque(random, static_cast<std::uint64_t>(i))[j];
        }
        ASSERT_NEAR(y[j], sum / static_cast<double>(n), 1e-12) << "rate " << rate;
      }
    }
  }
}

TEST(TorqueRateMatcherTest, KeepsATorqueStepWithinTheRateLimitThatBreaksItRaw) {
  // 4 Nm every 8 ms: 4000 Nm/s at once, 500 Nm/s spread.
  TorqueRateMatcher matcher(125);
  double last = 0;
  for (int k = 0; k < 80; ++k) {
    const int deposits = 1 + k / 8;
    const double tau = matcher.Next(Filled(4.0 * deposits))[0];
    EXPECT_NEAR((tau - last) / kCycleSeconds, 500, 1e-9);
    last = tau;
  }
}

TEST(TorqueRateMatcherTest, GivesAStalledTorqueExactlyAfterTheWindow) {
  const Random random(2, RandomStream::kTest);
  TorqueRateMatcher matcher(125);
  for (std::uint64_t k = 0; k < 1000; ++k) (void)matcher.Next(RandomTorque(random, k));
  const JointVector last = RandomTorque(random, 1000);
  for (int k = 0; k < 7; ++k) EXPECT_NE(matcher.Next(last), last);
  for (int k = 7; k < 30; ++k) EXPECT_EQ(matcher.Next(last), last);
}

TEST(TorqueRateMatcherTest, AllocatesNothing) {
  const Random random(3, RandomStream::kTest);
  TorqueRateMatcher matcher(10);
  JointVector y{};
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) y = matcher.Next(RandomTorque(random, k));
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(y[0], 0);
}

}  // namespace
}  // namespace twin::reference::reference_torque_rate_matcher_test
