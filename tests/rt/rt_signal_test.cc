#include "twin/rt/signal.h"

#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "support/realtime_guard.h"

namespace twin::rt::rt_signal_test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

constexpr Duration kLong = std::chrono::seconds(60);  // a test that hangs ends by its time limit

TEST(SignalTest, TellsOfANotificationThatCameBeforeTheWait) {
  const MonotonicClock clock;
  Signal signal(clock);
  signal.Notify();
  EXPECT_TRUE(signal.AwaitUntil(clock.Now() + kLong));
}

TEST(SignalTest, NotificationsBetweenTwoWaitsCountAsOne) {
  const MonotonicClock clock;
  Signal signal(clock);
  for (int i = 0; i < 3; ++i) signal.Notify();
  EXPECT_TRUE(signal.AwaitUntil(clock.Now() + kLong));
  EXPECT_FALSE(signal.AwaitUntil(clock.Now()));
}

TEST(SignalTest, ReturnsAtTheDeadlineAndNotBefore) {
  const MonotonicClock clock;
  Signal signal(clock);
  const Time deadline = clock.Now() + milliseconds(20);
  EXPECT_FALSE(signal.AwaitUntil(deadline));
  EXPECT_GE(clock.Now(), deadline);
}

TEST(SignalTest, ADeadlineThatHasPassedIsAMereLook) {
  const MonotonicClock clock;
  Signal signal(clock);
  for (const Time past : {clock.Now(), Time{}, Time(-hours(1000)), Time::min()}) {
    EXPECT_FALSE(signal.AwaitUntil(past));
    signal.Notify();
    EXPECT_TRUE(signal.AwaitUntil(past));
  }
}

TEST(SignalTest, WakesAWaiterThatHasNoDeadline) {
  const MonotonicClock clock;
  Signal signal(clock);
  bool notified = false;
  std::thread waiter([&] { notified = signal.AwaitUntil(Time::max()); });
  std::this_thread::sleep_for(milliseconds(5));  // it most likely sleeps by now; right either way
  signal.Notify();
  waiter.join();
  EXPECT_TRUE(notified);
}

TEST(SignalTest, WhatWasWrittenBeforeTheNotificationIsSeenBehindIt) {
  const MonotonicClock clock;
  Signal signal(clock);
  int value = 0;  // no atomic: the signal alone orders it
  std::thread notifier([&] {
    value = 42;
    signal.Notify();
  });
  EXPECT_TRUE(signal.AwaitUntil(Time::max()));
  EXPECT_EQ(value, 42);
  notifier.join();
}

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)  // they make calls of their own
TEST(SignalTest, NotifiesWithoutASystemCallWhenNobodyWaits) {
  // In a child from which the kernel takes all system calls but read, write and exit.
  EXPECT_EXIT(
      {
        const MonotonicClock clock;
        Signal signal(clock);
        static_cast<void>(signal.AwaitUntil(clock.Now()));
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) == 0) signal.Notify();
        syscall(SYS_exit, 0);
      },
      ::testing::ExitedWithCode(0), "");
}
#endif

TEST(SignalTest, NotifiesAndAwaitsWithoutAllocationOrLock) {
  const MonotonicClock clock;
  Signal signal(clock);
  const test::RealtimeGuard guard;
  int told = 0;
  for (int i = 0; i < 1000; ++i) {
    signal.Notify();
    told += signal.AwaitUntil(clock.Now() + kLong) ? 1 : 0;
    told += signal.AwaitUntil(clock.Now()) ? 1 : 0;
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(told, 1000);
}

}  // namespace
}  // namespace twin::rt::rt_signal_test
