#include "twin/rt/host_time.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace twin::rt::rt_sleep_test {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST(SleepTest, NeverReturnsBeforeItsDeadline) {
  const MonotonicClock clock;
  for (const Duration length : {Duration(1), Duration(microseconds(50)), Duration(milliseconds(3)),
                                Duration(milliseconds(20))}) {
    const Time deadline = clock.Now() + length;
    SleepUntil(clock, deadline);
    EXPECT_GE(clock.Now(), deadline);
  }
}

TEST(SleepTest, ReturnsWhenTheDeadlineHasPassed) {
  const MonotonicClock clock;
  SleepUntil(clock, clock.Now());
  SleepUntil(clock, Time{});
  SleepUntil(clock, Time(-hours(100000)));
  SleepUntil(clock, Time::min());
}

TEST(SleepTest, SleepsOnWhenASignalHandlerInterruptsIt) {
  static std::atomic<int> interruptions;
  struct sigaction action {};
  action.sa_handler = [](int) { ++interruptions; };
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGUSR1, &action, &before), 0);
  const MonotonicClock clock;
  // A busy machine may let the sleeper sleep all through before it runs this thread again.
  for (Duration length = milliseconds(50); interruptions == 0; length *= 2) {
    const Time deadline = clock.Now() + length;
    Time woken{};
    std::atomic<bool> over = false;
    std::thread sleeper([&] {
      SleepUntil(clock, deadline);
      woken = clock.Now();
      over = true;
    });
    while (!over) {
      pthread_kill(sleeper.native_handle(), SIGUSR1);
      std::this_thread::sleep_for(milliseconds(1));
    }
    sleeper.join();
    EXPECT_GE(woken, deadline);
  }
  sigaction(SIGUSR1, &before, nullptr);
}

}  // namespace
}  // namespace twin::rt::rt_sleep_test
