#include <gtest/gtest.h>

#include <ctime>
#include <limits>

#include "support/realtime_guard.h"
#include "twin/rt/host_time.h"

namespace twin::rt::rt_kernel_stamp_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// The wall clock's time, `later` from now.
timespec WallTime(Duration later) {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  const std::int64_t ns = wall.tv_sec * 1'000'000'000LL + wall.tv_nsec + later.count();
  return {static_cast<std::time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}

TEST(KernelStampTest, LiesBetweenTheStampAndTheLook) {
  const MonotonicClock clock;
  for (int i = 0; i < 1000; ++i) {
    const Time before = clock.Now();
    const timespec stamp = WallTime({});
    const Time at = TimeOfKernelStamp(clock, stamp);
    const Time after = clock.Now();
    EXPECT_GE(at, before);
    EXPECT_LE(at, after);
  }
}

TEST(KernelStampTest, GoesBackByTheStampsAge) {
  const MonotonicClock clock;
  for (const Duration age : {Duration(milliseconds(1)), Duration(milliseconds(400)),
                             Duration(milliseconds(999)), kOldestStamp}) {
    const Time before = clock.Now();
    const Time at = TimeOfKernelStamp(clock, WallTime(-age));
    const Time after = clock.Now();
    EXPECT_GE(at, before - age);
    EXPECT_LE(at, after - std::min(age, kOldestStamp));
  }
}

TEST(KernelStampTest, IsNowForAStampOfTheFuture) {
  const MonotonicClock clock;
  for (const Duration ahead : {Duration(seconds(1)), Duration(seconds(4000))}) {
    const Time before = clock.Now();
    const Time at = TimeOfKernelStamp(clock, WallTime(ahead));
    const Time after = clock.Now();
    EXPECT_GE(at, before);
    EXPECT_LE(at, after);
  }
}

TEST(KernelStampTest, IsBoundedForAnyStamp) {
  const MonotonicClock clock;
  constexpr std::time_t kFar = std::numeric_limits<std::time_t>::max() / 2;
  for (const std::time_t second : {std::time_t{0}, std::time_t{1}, -kFar, kFar}) {
    for (const long ns : {0L, 999'999'999L}) {
      const Time before = clock.Now();
      const Time at = TimeOfKernelStamp(clock, timespec{second, ns});
      const Time after = clock.Now();
      EXPECT_GE(at, before - kOldestStamp);
      EXPECT_LE(at, after);
    }
  }
}

TEST(KernelStampTest, IsForRealTime) {
  const MonotonicClock clock;
  const timespec stamp = WallTime({});
  Time last{};
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) last = std::max(last, TimeOfKernelStamp(clock, stamp));
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_GE(last, Time() - kOldestStamp);
}

}  // namespace
}  // namespace twin::rt::rt_kernel_stamp_test
