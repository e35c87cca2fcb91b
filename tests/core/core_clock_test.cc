#include "twin/core/clock.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "twin/core/time.h"

namespace twin::core_clock_test {
namespace {

TEST(MonotonicClockTest, StartsAtZeroAndNeverGoesBack) {
  const MonotonicClock clock;
  Time last{};
  for (int i = 0; i < 10'000; ++i) {
    const Time now = clock.Now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(MonotonicClockTest, CountsAtLeastTheTimeThatWasSlept) {
  const MonotonicClock clock;
  const Time before = clock.Now();
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_GE(clock.Now() - before, std::chrono::milliseconds(2));
}

TEST(TimeTest, CycleIsOneMillisecondInEitherUnit) {
  EXPECT_EQ(kCycle, Duration(1'000'000));
  EXPECT_EQ(FromSeconds(kCycleSeconds), kCycle);
  EXPECT_DOUBLE_EQ(ToSeconds(kCycle), kCycleSeconds);
}

TEST(TimeTest, FromSecondsSaturatesWhereSumsStayInRange) {
  const Duration most = FromSeconds(1e300);
  EXPECT_EQ(FromSeconds(std::numeric_limits<double>::infinity()), most);
  EXPECT_EQ(FromSeconds(std::nan("")), most);
  EXPECT_EQ(FromSeconds(-1e300), -most);
  EXPECT_GT(most + most, most);
}

TEST(TimeTest, FromSecondsRoundsToTheNearestNanosecond) {
  EXPECT_EQ(FromSeconds(1.4e-9), Duration(1));
  EXPECT_EQ(FromSeconds(1.6e-9), Duration(2));
  EXPECT_EQ(FromSeconds(-1.4e-9), Duration(-1));
  EXPECT_EQ(FromSeconds(-1.6e-9), Duration(-2));
  EXPECT_EQ(FromSeconds(18.32), Duration(18'320'000'000));
}

TEST(TimeTest, SecondsAndBackKeepEveryNanosecondOfAnHour) {
  for (std::int64_t ns = 0; ns < 3'600'000'000'000; ns += 7'777'777'777) {
    ASSERT_EQ(FromSeconds(ToSeconds(Duration(ns))), Duration(ns));
  }
}

}  // namespace
}  // namespace twin::core_clock_test
