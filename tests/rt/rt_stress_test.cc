// The hand-over between threads under load; clean under the thread sanitizer.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>

#include "support/effort.h"
#include "twin/rt/call_mailbox.h"
#include "twin/rt/latest_value.h"
#include "twin/rt/signal.h"
#include "twin/rt/spsc_ring.h"

namespace twin::rt::rt_stress_test {
namespace {

using std::chrono::microseconds;

constexpr Duration kLong = std::chrono::seconds(60);

TEST(RtStressTest, PingPongLosesNoWakeUp) {
  // A wake-up that is lost shows as a wait that ends without a notification.
  constexpr int kRounds = test::Repetitions(20'000);
  const MonotonicClock clock;
  Signal ping(clock);
  Signal pong(clock);
  int ball = 0;  // no atomic: handed over by the signals alone
  int missed = 0;
  std::thread other([&] {
    for (int i = 0; i < kRounds; ++i) {
      if (!ping.AwaitUntil(clock.Now() + kLong)) return;
      ++ball;
      pong.Notify();
    }
  });
  for (int i = 0; i < kRounds && missed == 0; ++i) {
    ++ball;
    ping.Notify();
    if (!pong.AwaitUntil(clock.Now() + kLong)) ++missed;
  }
  other.join();
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(ball, 2 * kRounds);
}

TEST(RtStressTest, AWaiterWithShortDeadlinesSeesTheLastNotification) {
  // Deadlines of a few microseconds keep the waiter between announcing itself and sleeping.
  constexpr std::uint32_t kNotifications = test::Repetitions(50'000);
  const MonotonicClock clock;
  Signal signal(clock);
  std::atomic<std::uint32_t> sent = 0;
  std::thread notifier([&] {
    for (std::uint32_t i = 1; i <= kNotifications; ++i) {
      sent.store(i, std::memory_order_relaxed);
      signal.Notify();
      if (i % 64 == 0) std::this_thread::yield();
    }
  });
  std::uint32_t seen = 0;
  std::uint32_t wakes = 0;
  while (seen < kNotifications) {
    if (!signal.AwaitUntil(clock.Now() + microseconds(wakes % 50))) continue;
    ++wakes;
    seen = sent.load(std::memory_order_relaxed);
  }
  notifier.join();
  EXPECT_LE(wakes, kNotifications);
  // The last count may have been read before its notification was given.
  static_cast<void>(signal.AwaitUntil(clock.Now()));
  EXPECT_FALSE(signal.AwaitUntil(clock.Now())) << "a notification counted twice";
}

TEST(RtStressTest, ManyThreadsWakeOneWaiter) {
  constexpr int kNotifiers = 4;
  constexpr int kEach = test::Repetitions(5'000);
  const MonotonicClock clock;
  Signal signal(clock);
  std::atomic<int> sent = 0;
  std::array<std::thread, kNotifiers> notifiers;
  for (std::thread& notifier : notifiers) {
    notifier = std::thread([&] {
      for (int i = 0; i < kEach; ++i) {
        sent.fetch_add(1, std::memory_order_relaxed);
        signal.Notify();
      }
    });
  }
  bool missed = false;
  while (!missed && sent.load(std::memory_order_relaxed) < kNotifiers * kEach) {
    // The last of all notifications can only have been counted before the loop looked at `sent`.
    missed = !signal.AwaitUntil(clock.Now() + kLong) &&
             sent.load(std::memory_order_relaxed) < kNotifiers * kEach;
  }
  for (std::thread& notifier : notifiers) notifier.join();
  EXPECT_FALSE(missed);
}

TEST(RtStressTest, CallsRunOnceOrNeverWhateverTheTimeout) {
  class Adding final : public Call {
   public:
    explicit Adding(int& sum) : sum_(sum) {}
    void Run() noexcept override { ++sum_; }

   private:
    int& sum_;  // no atomic: ordered by the box
  };
  const MonotonicClock clock;
  CallMailbox box(clock);
  int sum = 0;
  std::jthread servant([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      box.RunPending();
      std::this_thread::yield();
    }
  });
  int done = 0;
  constexpr int kCalls = test::Repetitions(20'000);
  for (int i = 0; i < kCalls || done == 0; ++i) {  // the other thread may come late to its first
    Adding call(sum);  // its own each time: one used after it was taken back shows
    const bool ran = box.Execute(call, microseconds(i % 40));
    done += ran ? 1 : 0;
  }
  servant.request_stop();
  servant.join();
  EXPECT_EQ(sum, done);
}

/// Wider than any single store, so that a torn value shows.
using Wide = std::array<std::uint64_t, 16>;

TEST(RtStressTest, StatesThroughLatestValueAndCommandsThroughTheRingKeepTheirOrder) {
  // The pattern of the realtime robot: the newest state one way with a signal, commands the other.
  constexpr std::uint64_t kStates = test::Repetitions(20'000);
  const MonotonicClock clock;
  const auto latest = std::make_unique<LatestValue<Wide>>();
  SpscRing<Wide> ring(64);
  Signal arrived(clock);
  std::atomic<bool> workstation_done = false;
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t answers = 0;

  std::thread robot([&] {
    Wide state;
    std::uint64_t last = 0;
    const auto drain = [&] {
      while (ring.TryPopWith([&](const Wide& command) {
        for (const std::uint64_t word : command) torn += word != command.front() ? 1 : 0;
        backwards += command.front() <= last ? 1 : 0;
        last = command.front();
        ++answers;
      })) {
      }
    };
    for (std::uint64_t id = 1; id <= kStates; ++id) {
      state.fill(id);
      latest->Publish(state);
      arrived.Notify();
      drain();
      if (id % 16 == 0) std::this_thread::yield();
    }
    while (!workstation_done.load(std::memory_order_acquire)) drain();
    drain();
  });

  std::uint64_t written = 0;
  std::uint64_t torn_states = 0;
  std::uint64_t newest = 0;
  bool silent = false;
  while (newest < kStates && !silent) {
    if (!latest->Refresh()) {
      silent = !arrived.AwaitUntil(clock.Now() + kLong);
      continue;
    }
    const Wide& state = latest->value();
    for (const std::uint64_t word : state) torn_states += word != state.front() ? 1 : 0;
    newest = state.front();
    written += ring.TryPush(state) ? 1 : 0;
  }
  workstation_done.store(true, std::memory_order_release);
  robot.join();
  EXPECT_FALSE(silent) << "no notification after state " << newest;
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(torn_states, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(answers, written);
}

}  // namespace
}  // namespace twin::rt::rt_stress_test
