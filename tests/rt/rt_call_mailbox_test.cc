#include "twin/rt/call_mailbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "support/realtime_guard.h"

namespace twin::rt::rt_call_mailbox_test {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLong = std::chrono::seconds(60);

/// Counts how often it ran, and on which thread.
class Counting final : public Call {
 public:
  void Run() noexcept override {
    ++runs;
    thread = std::this_thread::get_id();
  }
  int runs = 0;
  std::thread::id thread;
};

/// A thread that runs what is pending, until it goes.
class Executor {
 public:
  explicit Executor(CallMailbox& box)
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

TEST(CallMailboxTest, RunsTheCallOnceOnTheOtherThread) {
  const MonotonicClock clock;
  CallMailbox box(clock);
  Counting call;
  const Executor servant(box);
  EXPECT_TRUE(box.Execute(call, kLong));
  EXPECT_EQ(call.runs, 1);
  EXPECT_EQ(call.thread, servant.id());
}

TEST(CallMailboxTest, ServesOneAfterTheOther) {
  const MonotonicClock clock;
  CallMailbox box(clock);
  Counting call;
  const Executor servant(box);
  for (int i = 1; i <= 100; ++i) {
    ASSERT_TRUE(box.Execute(call, kLong));
    ASSERT_EQ(call.runs, i);
  }
}

TEST(CallMailboxTest, TakesBackWhatNobodyBegan) {
  const MonotonicClock clock;
  CallMailbox box(clock);
  Counting call;
  EXPECT_FALSE(box.Execute(call, milliseconds(5)));
  box.RunPending();
  EXPECT_EQ(call.runs, 0);
}

TEST(CallMailboxTest, ServesANewCallAfterOneThatWasTakenBack) {
  const MonotonicClock clock;
  CallMailbox box(clock);
  Counting forgotten;
  ASSERT_FALSE(box.Execute(forgotten, milliseconds(1)));
  Counting call;
  const Executor servant(box);
  EXPECT_TRUE(box.Execute(call, kLong));
  EXPECT_EQ(call.runs, 1);
  EXPECT_EQ(forgotten.runs, 0);
}

TEST(CallMailboxTest, WaitsForAnCallThatHasBegunHoweverLongItTakes) {
  class Slow final : public Call {
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
  CallMailbox box(clock);
  Slow call;
  const Executor servant(box);
  std::thread releaser([&] {
    while (!call.begun) std::this_thread::yield();
    std::this_thread::sleep_for(milliseconds(20));  // beyond the timeout below, most likely
    call.may_end = true;
  });
  const bool done = box.Execute(call, milliseconds(5));
  if (!done) call.begun = call.may_end = true;  // the other thread slept for the whole timeout
  releaser.join();
  EXPECT_EQ(done, call.ended);
}

TEST(CallMailboxTest, RunsWithoutAllocationOrLock) {
  class Nothing final : public Call {
   public:
    void Run() noexcept override {}
  };
  const MonotonicClock clock;
  CallMailbox box(clock);
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
  Nothing call;
  int done = 0;
  for (int i = 0; i < 100; ++i) done += box.Execute(call, kLong) ? 1 : 0;
  over = true;
  servant.join();
  EXPECT_EQ(done, 100);
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::rt::rt_call_mailbox_test
