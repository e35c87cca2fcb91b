#include "twin/loop/shared_time.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::loop::loop_shared_time_test {
namespace {

rt::ThreadSettings Ordinary() {
  return {.name = "robots", .lock_memory = false};
}

/// Runs `robot` with each seat on a thread of its own, and waits for all.
void Together(std::size_t robots, const std::function<void(std::size_t)>& robot) {
  std::vector<std::jthread> threads;
  threads.reserve(robots);
  for (std::size_t i = 0; i < robots; ++i) threads.emplace_back(robot, i);
}

TEST(SharedTimeTest, BeginsWithTheLastAndEndsWithTheLast) {
  constexpr int kRobots = 3;
  SharedTime time(kRobots, Ordinary(), {});
  std::atomic<int> getting_ready = 0;
  std::atomic<int> ready = 0;
  std::atomic<int> wants_to_end = 0;
  std::atomic<int> bodies = 0;
  Together(kRobots, [&](std::size_t /*i*/) {
    SharedTime::Seat seat(time, [&] { ++wants_to_end; });
    EXPECT_EQ(++getting_ready, 1) << "one after the other";
    seat.thread().Add([&](const std::stop_token& stop) {
      EXPECT_EQ(ready, kRobots);
      ++bodies;
      while (!stop.stop_requested())
        rt::FiberThread::SleepUntil(*seat.clock(), seat.clock()->Now());
      EXPECT_EQ(wants_to_end, kRobots);
      --bodies;
    });
    ++ready;
    --getting_ready;
    seat.Begin();
    EXPECT_EQ(ready, kRobots);
    seat.End();
    EXPECT_EQ(wants_to_end, kRobots);
    EXPECT_EQ(bodies, 0);
    seat.End();
  });
}

TEST(SharedTimeTest, AllHaveOneClockThatBeginsWithThem) {
  const MonotonicClock other;
  SharedTime time(2, Ordinary(), {});
  std::array<std::shared_ptr<MonotonicClock>, 2> clocks;
  std::array<Time, 2> ready;  // by the other clock
  Together(2, [&](std::size_t i) {
    SharedTime::Seat seat(time, {});
    clocks[i] = seat.clock();
    ready[i] = other.Now();
    seat.Begin();
    seat.End();
  });
  EXPECT_EQ(clocks[0], clocks[1]);
  const Time begun(Duration(clocks[0]->MonotonicNs(Time()) - other.MonotonicNs(Time())));
  EXPECT_GE(begun, std::max(ready[0], ready[1]));
}

TEST(SharedTimeTest, NobodyWaitsForARobotThatLeaves) {
  SharedTime time(3, Ordinary(), {});
  std::atomic<int> ended = 0;
  Together(3, [&](std::size_t i) {
    SharedTime::Seat seat(time, {});
    if (i == 1) return;  // before it was ready
    seat.Begin();
    if (i == 0) return;  // without a word
    seat.End();
    ++ended;
  });
  EXPECT_EQ(ended, 1);
}

TEST(SharedTimeTest, TellsAllThatTheThreadCannotBeSetUp) {
  rt::ThreadSettings impossible = Ordinary();
  impossible.cpu = 9999;
  SharedTime time(2, impossible, {});
  std::atomic<int> told = 0;
  Together(2, [&](std::size_t /*i*/) {
    SharedTime::Seat seat(time, {});
    try {
      seat.Begin();
    } catch (const InputError&) {
      ++told;
    }
  });
  EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace twin::loop::loop_shared_time_test
