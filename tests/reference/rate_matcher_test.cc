#include "twin/reference/rate_matcher.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include <gmock/gmock.h>

#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::reference::rate_matcher_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

JointTarget Everywhere(double value) {
  JointTarget u;
  u.q.fill(value);
  u.dq.fill(value);
  u.ddq.fill(value);
  return u;
}

JointTarget RandomTarget(const Random& random, std::uint64_t tick) {
  JointTarget u;
  for (std::uint32_t j = 0; j < kJoints; ++j) {
    u.q[j] = 6 * random.Uniform(tick, j) - 3;
    u.dq[j] = 4 * random.Uniform(tick, 10 + j) - 2;
    u.ddq[j] = 20 * random.Uniform(tick, 20 + j) - 10;
  }
  return u;
}

TEST(RateMatcherTest, WindowIsTheRatioOfTheRatesRoundedUp) {
  EXPECT_EQ(RateMatcher(1000).window(), 1u);
  EXPECT_EQ(RateMatcher(500).window(), 2u);
  EXPECT_EQ(RateMatcher(400).window(), 3u);
  EXPECT_EQ(RateMatcher(1000.0 / 3).window(), 3u);
  EXPECT_EQ(RateMatcher(125).window(), 8u);
  EXPECT_EQ(RateMatcher(1).window(), 1000u);
}

TEST(RateMatcherTest, RefusesRatesOutOfRange) {
  for (const double rate : {0.999, 1000.1, -125.0, 0.0}) {
    EXPECT_THAT([&] { RateMatcher matcher(rate); },
                ThrowsMessage<InputError>(HasSubstr("it must lie in [1, 1000]")));
  }
  EXPECT_THAT([] { RateMatcher matcher(std::nan("")); },
              ThrowsMessage<InputError>(HasSubstr("the source's rate is nan Hz")));
}

TEST(RateMatcherTest, TurnsAStaircaseIntoARampWithTheIntendedIncrement) {
  constexpr double kRiser = 0.08;  // per 8 cycles
  RateMatcher matcher(125);
  matcher.Reset(Everywhere(0));
  double before = 0;
  for (int k = 0; k < 80; ++k) {
    const int deposits = 1 + k / 8;
    const double u = kRiser * deposits;
    const JointTarget y = matcher.Next(Everywhere(u));
    EXPECT_NEAR(y.q[3] - before, kRiser / 8, 1e-15) << "cycle " << k;
    EXPECT_EQ(y.q[3], y.dq[3]);
    EXPECT_EQ(y.q[3], y.ddq[3]);
    before = y.q[3];
  }
}

TEST(RateMatcherTest, DelaysALineByHalfTheWindow) {
  for (const double rate : {500.0, 125.0, 10.0}) {
    RateMatcher matcher(rate);
    const auto n = static_cast<double>(matcher.window());
    for (int k = 0; k < 300; ++k) {
      const double y = matcher.Next(Everywhere(0.01 * k)).q[0];
      if (k >= n) {
        EXPECT_NEAR(y, 0.01 * (k - (n - 1) / 2), 1e-14);
      }
    }
  }
}

TEST(RateMatcherTest, PassesEverythingThroughAtTheCycleRate) {
  const Random random(1, RandomStream::kTest);
  RateMatcher matcher(1000);
  for (std::uint64_t k = 0; k < 20; ++k) {
    const JointTarget u = RandomTarget(random, k);
    const JointTarget y = matcher.Next(u);
    EXPECT_EQ(y.q, u.q);
    EXPECT_EQ(y.dq, u.dq);
    EXPECT_EQ(y.ddq, u.ddq);
  }
}

TEST(RateMatcherTest, StartsAtTheResetValueWithoutAStep) {
  RateMatcher matcher(125);
  const JointTarget u0 = RandomTarget(Random(2, RandomStream::kTest), 0);
  matcher.Reset(u0);
  EXPECT_EQ(matcher.Next(u0).q, u0.q);
  JointTarget moved = u0;
  moved.q[5] += 0.8;
  EXPECT_NEAR(matcher.Next(moved).q[5], u0.q[5] + 0.1, 1e-15);
}

TEST(RateMatcherTest, GivesAStalledValueExactlyAfterTheWindow) {
  const Random random(3, RandomStream::kTest);
  RateMatcher matcher(1000.0 / 7);
  for (std::uint64_t k = 0; k < 1000; ++k) (void)matcher.Next(RandomTarget(random, k));
  JointTarget last = RandomTarget(random, 1000);
  last.dq[2] = 0;
  for (int k = 0; k < 6; ++k) EXPECT_NE(matcher.Next(last).q, last.q);
  for (int k = 6; k < 40; ++k) {
    const JointTarget y = matcher.Next(last);
    EXPECT_EQ(y.q, last.q);
    EXPECT_EQ(y.dq, last.dq);
    EXPECT_EQ(y.ddq, last.ddq);
  }
}

TEST(RateMatcherTest, DoesNotDriftInAMillionCycles) {
  const Random random(4, RandomStream::kTest);
  RateMatcher matcher(125);
  std::deque<double> window(8, 0.0);
  JointTarget u{};
  for (std::uint64_t k = 0; k < 1'000'000; ++k) {
    // Magnitudes over many decades: what a plain running sum would never forget.
    u.q[1] = random.Normal(k) * ((k & 64) != 0 ? 1e6 : 1e-3);
    window.pop_front();
    window.push_back(u.q[1]);
    const double y = matcher.Next(u).q[1];
    if (k % 1000 > 8) continue;
    long double sum = 0;
    double largest = 0;
    for (const double value : window) {
      sum += value;
      largest = std::max(largest, std::abs(value));
    }
    const double ulp = std::nextafter(largest, 1e9) - largest;
    ASSERT_NEAR(y, static_cast<double>(sum / 8), 2 * ulp) << "cycle " << k;
  }
}

TEST(RateMatcherTest, ForgetsAValueThatIsNotFinite) {
  const Random random(5, RandomStream::kTest);
  for (std::uint64_t at = 0; at < 8; ++at) {
    RateMatcher matcher(125);
    JointTarget y;
    for (std::uint64_t k = 0; k <= at + 16; ++k) {
      JointTarget u = RandomTarget(random, k);
      if (k == at) u.q[0] = std::numeric_limits<double>::infinity();
      y = matcher.Next(u);
      if (k == at) {
        EXPECT_FALSE(std::isfinite(y.q[0]));
      }
      EXPECT_TRUE(std::isfinite(y.q[1]));
    }
    EXPECT_TRUE(std::isfinite(y.q[0])) << "deposited in cycle " << at;
  }
}

TEST(RateMatcherTest, AllocatesNothing) {
  RateMatcher matcher(10);
  const Random random(6, RandomStream::kTest);
  const test::RealtimeGuard guard;
  double sum = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) sum += matcher.Next(RandomTarget(random, k)).q[0];
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_NE(sum, 0);
}

}  // namespace
}  // namespace twin::reference::rate_matcher_test
