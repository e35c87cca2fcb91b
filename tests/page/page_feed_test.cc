#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/clock.h"
#include "twin/page/live_feed.h"

namespace twin::page::page_feed_test {
namespace {

using std::chrono::milliseconds;

struct Keeper final : record::RecordSink {
  void Put(const record::CycleRecord& record) noexcept override {
    last = record.at;
    ++cycles;
  }
  void Put(const record::TickRecord& /*record*/) noexcept override { ++ticks; }
  Time last{};
  int cycles = 0;
  int ticks = 0;
};

record::CycleRecord CycleAt(Duration at) {
  record::CycleRecord record;
  record.at = Time(at);
  record.fate = record::CommandFate::kServed;
  return record;
}

TEST(LiveFeedTest, PassesEveryRecordOn) {
  Keeper keeper;
  LiveFeed feed(&keeper);
  for (int i = 0; i < 100; ++i) feed.Put(CycleAt(milliseconds(i)));
  feed.Put(record::TickRecord{});
  EXPECT_EQ(keeper.cycles, 100);
  EXPECT_EQ(keeper.ticks, 1);
}

TEST(LiveFeedTest, ShowsSomeSixtyASecond) {
  LiveFeed feed(nullptr);
  int shown = 0;
  for (int i = 0; i < 1000; ++i) {
    feed.Put(CycleAt(milliseconds(i)));
    shown += feed.arm().Refresh() ? 1 : 0;
  }
  EXPECT_EQ(shown, 59);  // 1000 / 17, and the first
}

TEST(LiveFeedTest, CountsCyclesWithAndWithoutACommand) {
  LiveFeed feed(nullptr);
  record::CycleRecord held = CycleAt(milliseconds(0));
  held.fate = record::CommandFate::kHeld;
  feed.Put(CycleAt(milliseconds(0)));
  feed.Put(held);
  feed.Put(held);
  feed.Put(CycleAt(milliseconds(17)));
  ASSERT_TRUE(feed.arm().Refresh());
  EXPECT_EQ(feed.arm().value().served, 2U);
  EXPECT_EQ(feed.arm().value().held, 2U);
}

TEST(LiveFeedTest, AllocatesAndLocksNothing) {
  LiveFeed feed(nullptr);
  const record::CycleRecord record = CycleAt(milliseconds(0));
  const test::RealtimeGuard guard;
  record::CycleRecord next = record;
  for (int i = 0; i < 1000; ++i) {
    next.at = Time(milliseconds(i));
    feed.Put(next);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

TEST(LiveFeedTest, HoldsAVirtualClockBackToTheWalls) {
  const MonotonicClock wall;
  LiveFeed feed(nullptr);
  feed.KeepPace(wall);
  const Time begin = wall.Now();
  feed.Put(CycleAt(milliseconds(0)));
  feed.Put(CycleAt(milliseconds(50)));
  EXPECT_GE(wall.Now() - begin, milliseconds(49));
}

TEST(LiveFeedTest, LetsARunStandWhileItIsPaused) {
  const MonotonicClock wall;
  LiveFeed feed(nullptr);
  feed.KeepPace(wall);
  feed.Pause(true);
  std::atomic<bool> goes_on{false};
  bool waited = false;
  std::jthread run([&] {
    feed.Put(CycleAt(milliseconds(0)));
    waited = goes_on;
  });
  while (!feed.arm().Refresh())
    std::this_thread::yield();  // the cycle is shown, and the run stands
  goes_on = true;
  feed.Pause(false);
  run.join();
  EXPECT_TRUE(waited);
}

TEST(LiveFeedTest, HurriesNotAfterAPause) {
  const MonotonicClock wall;
  LiveFeed feed(nullptr);
  feed.KeepPace(wall);
  feed.Put(CycleAt(milliseconds(0)));
  feed.Pause(true);
  std::jthread run([&] { feed.Put(CycleAt(milliseconds(1))); });
  const Time begin = wall.Now();
  while (wall.Now() - begin < milliseconds(300)) std::this_thread::yield();
  const Time resumed = wall.Now();
  feed.Pause(false);
  run.join();
  feed.Put(CycleAt(milliseconds(51)));
  EXPECT_GE(wall.Now() - resumed, milliseconds(49));
}

TEST(LiveFeedTest, AnInterruptEndsAPause) {
  const MonotonicClock wall;
  const volatile bool interrupted = true;
  LiveFeed feed(nullptr);
  feed.KeepPace(wall, &interrupted);
  feed.Pause(true);
  feed.Put(CycleAt(milliseconds(0)));
  EXPECT_TRUE(feed.arm().Refresh());
}

}  // namespace
}  // namespace twin::page::page_feed_test
