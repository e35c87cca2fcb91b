#include "twin/rt/fiber_thread.h"

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::rt::rt_fiber_thread_test {
namespace {

using std::chrono::milliseconds;

ThreadSettings Ordinary() {
  return {.name = "shared", .lock_memory = false};
}

TEST(FiberThreadTest, RunsThoseThatAreDueInTheirOrder) {
  const MonotonicClock clock;
  std::string order;
  FiberThread thread(Ordinary(), {});
  // The second sleeps for less, so it is the first to wake.
  for (const auto& [name, sleep] : {std::pair{'a', milliseconds(60)}, {'b', milliseconds(20)}}) {
    thread.Add([&, name, sleep](const std::stop_token& /*stop*/) {
      const Time begun = clock.Now();
      order += name;
      FiberThread::SleepUntil(clock, begun + sleep);
      order += name;
      EXPECT_GE(clock.Now(), begun + sleep);
    });
  }
  static_cast<void>(thread.Start());
  thread.Stop();  // which waits for the ends
  EXPECT_EQ(order, "abba");
}

TEST(FiberThreadTest, LetsOneWaitForAnother) {
  std::vector<int> met;
  int here = 0;
  FiberThread thread(Ordinary(), {});
  const MonotonicClock clock;
  for (int i = 0; i < 2; ++i) {
    thread.Add([&, i](const std::stop_token& /*stop*/) {
      FiberThread::SleepUntil(clock, clock.Now() + i * milliseconds(5));
      ++here;
      while (here < 2) FiberThread::GiveWay();
      met.push_back(i);
    });
  }
  static_cast<void>(thread.Start());
  thread.Stop();
  // The one that came last does not wait.
  EXPECT_EQ(met, (std::vector{1, 0}));
}

TEST(FiberThreadTest, StopsOneThatWaitsInVain) {
  std::atomic<bool> released = false;
  bool stop_came_first = false;
  FiberThread thread(Ordinary(), [&released] { released = true; });
  thread.Add([&](const std::stop_token& stop) {
    while (!released) FiberThread::GiveWay();
    stop_came_first = stop.stop_requested();
  });
  static_cast<void>(thread.Start());
  thread.Stop();
  thread.Stop();
  EXPECT_TRUE(released);
  EXPECT_TRUE(stop_came_first);  // it was resumed after both
}

TEST(FiberThreadTest, AllocatesAndLocksNothing) {
  const MonotonicClock clock;
  std::optional<test::RealtimeGuard::Counts> counts;
  FiberThread thread(Ordinary(), {});
  thread.Add([&](const std::stop_token& /*stop*/) {
    const test::RealtimeGuard guard;
    for (int i = 0; i < 20; ++i) {
      FiberThread::SleepUntil(clock, clock.Now() + milliseconds(1));
      FiberThread::GiveWay();
    }
    counts = guard.counts();
  });
  thread.Add([&](const std::stop_token& /*stop*/) {
    while (!counts) FiberThread::SleepUntil(clock, clock.Now() + milliseconds(1));
  });
  static_cast<void>(thread.Start());
  thread.Stop();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

}  // namespace
}  // namespace twin::rt::rt_fiber_thread_test
