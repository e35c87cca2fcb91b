#include "twin/rt/errand.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "support/realtime_guard.h"

namespace twin::rt {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLong = std::chrono::seconds(60);

/// Counts how often it ran, and on which thread.
class Counting final : public Errand {
 public:
  void Run() noexcept override {
    ++runs;
    thread = std::this_thread::get_id();
  }
  int runs = 0;
  std::thread::id thread;
};

/// A thread that runs what is pending, until it goes.
class Servant {
 public:
  explicit Servant(ErrandBox& box)
      : thread_([&box](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            box.RunPending();
            std::this_thread::yield();
          }
        }) {}
  [[nodiscard]] std::thread::id id() const { return thread_.get_id(); }

 private:
  std::jthread thread_;
};

TEST(ErrandBoxTest, RunsTheErrandOnceOnTheOtherThread) {
  const MonotonicClock clock;
  ErrandBox box(clock);
  Counting errand;
  const Servant servant(box);
  EXPECT_TRUE(box.Do(errand, kLong));
  EXPECT_EQ(errand.runs, 1);
  EXPECT_EQ(errand.thread, servant.id());
}

TEST(ErrandBoxTest, ServesOneAfterTheOther) {
  const MonotonicClock clock;
  ErrandBox box(clock);
  Counting errand;
  const Servant servant(box);
  for (int i = 1; i <= 100; ++i) {
    ASSERT_TRUE(box.Do(errand, kLong));
    ASSERT_EQ(errand.runs, i);
  }
}

TEST(ErrandBoxTest, TakesBackWhatNobodyBegan) {
  const MonotonicClock clock;
  ErrandBox box(clock);
  Counting errand;
  EXPECT_FALSE(box.Do(errand, milliseconds(5)));
  box.RunPending();
  EXPECT_EQ(errand.runs, 0);
}

TEST(ErrandBoxTest, ServesANewErrandAfterOneThatWasTakenBack) {
  const MonotonicClock clock;
  ErrandBox box(clock);
  Counting forgotten;
  ASSERT_FALSE(box.Do(forgotten, milliseconds(1)));
  Counting errand;
  const Servant servant(box);
  EXPECT_TRUE(box.Do(errand, kLong));
  EXPECT_EQ(errand.runs, 1);
  EXPECT_EQ(forgotten.runs, 0);
}

TEST(ErrandBoxTest, WaitsForAnErrandThatHasBegunHoweverLongItTakes) {
  class Slow final : public Errand {
   public:
    void Run() noexcept override {
      begun = true;
      while (!may_end) std::this_thread::yield();
      ended = true;
    }
    std::atomic<bool> begun = false;
    std::atomic<bool> may_end = false;
    bool ended = false;
  };
  const MonotonicClock clock;
  ErrandBox box(clock);
  Slow errand;
  const Servant servant(box);
  std::thread releaser([&] {
    while (!errand.begun) std::this_thread::yield();
    std::this_thread::sleep_for(milliseconds(20));  // beyond the patience below, most likely
    errand.may_end = true;
  });
  const bool done = box.Do(errand, milliseconds(5));
  if (!done) errand.begun = errand.may_end = true;  // the servant slept for the whole patience
  releaser.join();
  EXPECT_EQ(done, errand.ended);
}

TEST(ErrandBoxTest, RunsWithoutAllocationOrLock) {
  class Nothing final : public Errand {
   public:
    void Run() noexcept override {}
  };
  const MonotonicClock clock;
  ErrandBox box(clock);
  std::atomic<bool> over = false;
  test::RealtimeGuard::Counts counts;
  std::thread servant([&] {
    const test::RealtimeGuard guard;
    while (!over) {
      box.RunPending();
      std::this_thread::yield();
    }
    counts = guard.counts();
  });
  Nothing errand;
  int done = 0;
  for (int i = 0; i < 100; ++i) done += box.Do(errand, kLong) ? 1 : 0;
  over = true;
  servant.join();
  EXPECT_EQ(done, 100);
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::rt
