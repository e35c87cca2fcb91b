#include "twin/rt/event_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/random.h"

namespace twin::rt::rt_event_queue_test {
namespace {

using ::testing::ElementsAre;

struct Seen {
  Time at;
  std::uint64_t token;
  bool operator==(const Seen&) const = default;
};

/// Keeps what it was called with; room is taken at construction.
class Recorder final : public EventHandler {
 public:
  explicit Recorder(std::size_t most = 64) { seen_.reserve(most); }
  void OnEvent(Time now, std::uint64_t token) noexcept override { seen_.push_back({now, token}); }
  [[nodiscard]] const std::vector<Seen>& seen() const { return seen_; }
  [[nodiscard]] std::vector<std::uint64_t> tokens() const {
    std::vector<std::uint64_t> tokens;
    for (const Seen& seen : seen_) tokens.push_back(seen.token);
    return tokens;
  }

 private:
  std::vector<Seen> seen_;
};

Time At(std::int64_t ns) {
  return Time(Duration(ns));
}

void RunAll(EventQueue& queue) {
  while (queue.RunNext()) {
  }
}

TEST(EventQueueTest, RunsEventsInOrderOfTime) {
  EventQueue queue;
  Recorder recorder;
  queue.Schedule(At(30), EventOrder::kOnboardCycle, recorder, 3);
  queue.Schedule(At(10), EventOrder::kOnboardCycle, recorder, 1);
  queue.Schedule(At(20), EventOrder::kOnboardCycle, recorder, 2);
  RunAll(queue);
  EXPECT_THAT(recorder.seen(), ElementsAre(Seen{At(10), 1}, Seen{At(20), 2}, Seen{At(30), 3}));
}

TEST(EventQueueTest, RunsEventsOfOneInstantInTheirFixedOrder) {
  EventQueue queue;
  Recorder recorder;
  queue.Schedule(At(5), EventOrder::kControllerWake, recorder, 5);
  queue.Schedule(At(5), EventOrder::kTickDone, recorder, 4);
  queue.Schedule(At(5), EventOrder::kStateArrival, recorder, 3);
  queue.Schedule(At(5), EventOrder::kControllerDone, recorder, 2);
  queue.Schedule(At(5), EventOrder::kOnboardCycle, recorder, 1);
  queue.Schedule(At(5), EventOrder::kCommandArrival, recorder, 0);
  RunAll(queue);
  EXPECT_THAT(recorder.tokens(), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(EventQueueTest, RunsEqualEventsInTheOrderTheyWereScheduled) {
  EventQueue queue;
  Recorder recorder;
  for (std::uint64_t token = 0; token < 6; ++token) {
    queue.Schedule(At(1), EventOrder::kStateArrival, recorder, token);
  }
  RunAll(queue);
  EXPECT_THAT(recorder.tokens(), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(EventQueueTest, TimeMovesOnlyWhenAnEventRuns) {
  EventQueue queue;
  Recorder recorder;
  EXPECT_EQ(queue.Now(), Time{});
  queue.Schedule(At(7), EventOrder::kOnboardCycle, recorder);
  EXPECT_EQ(queue.Now(), Time{});
  EXPECT_TRUE(queue.RunNext());
  EXPECT_EQ(queue.Now(), At(7));
  EXPECT_FALSE(queue.RunNext());
  EXPECT_EQ(queue.Now(), At(7));
}

/// Schedules a follow-up at the very instant it runs, once.
class Chained final : public EventHandler {
 public:
  Chained(EventQueue& queue, Recorder& next) : queue_(queue), next_(next) {}
  void OnEvent(Time now, std::uint64_t token) noexcept override {
    queue_.Schedule(now, EventOrder::kCommandArrival, next_, token);
  }

 private:
  EventQueue& queue_;
  Recorder& next_;
};

TEST(EventQueueTest, AnEventMayScheduleOneForItsOwnInstant) {
  EventQueue queue;
  Recorder recorder;
  Chained chained(queue, recorder);
  queue.Schedule(At(4), EventOrder::kStateArrival, chained, 9);
  queue.Schedule(At(5), EventOrder::kCommandArrival, recorder, 1);
  RunAll(queue);
  EXPECT_THAT(recorder.seen(), ElementsAre(Seen{At(4), 9}, Seen{At(5), 1}));
}

/// The second implementation: a list kept in order by a stable sort.
class SortedList {
 public:
  void Schedule(Time at, EventOrder order, std::uint64_t token) {
    events_.push_back({at, order, token});
    std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
      return a.at != b.at ? a.at < b.at : a.order < b.order;
    });
  }
  Seen PopFirst() {
    const Event first = events_.front();
    events_.erase(events_.begin());
    return {first.at, first.token};
  }
  [[nodiscard]] bool empty() const { return events_.empty(); }

 private:
  struct Event {
    Time at;
    EventOrder order;
    std::uint64_t token;
  };
  std::vector<Event> events_;
};

class EventQueueRandomTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(EventQueueRandomTest, AgreesWithAStableSortOnARandomStream) {
  constexpr std::uint64_t kSteps = 4000;
  const Random random(GetParam(), RandomStream::kTest);
  EventQueue queue(kSteps);
  Recorder recorder(kSteps);
  SortedList reference;
  std::vector<Seen> expected;
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    const auto bits = random.Bits(step);
    if (bits[0] % 5 < 3 && queue.pending() < 100) {  // instants and orders collide often
      const Time at = queue.Now() + Duration(bits[1] % 8);
      const auto order = static_cast<EventOrder>(bits[2] % 6);
      queue.Schedule(at, order, recorder, step);
      reference.Schedule(at, order, step);
    } else if (!reference.empty()) {
      expected.push_back(reference.PopFirst());
      ASSERT_TRUE(queue.RunNext());
    } else {
      ASSERT_FALSE(queue.RunNext());
    }
  }
  ASSERT_GT(expected.size(), kSteps / 4);
  EXPECT_EQ(recorder.seen(), expected);
}

INSTANTIATE_TEST_SUITE_P(Seeds, EventQueueRandomTest, testing::Range<std::uint64_t>(0, 8));

TEST(EventQueueDeathTest, RefusesMoreEventsThanItsCapacity) {
  EventQueue queue(2);
  Recorder recorder;
  queue.Schedule(At(1), EventOrder::kOnboardCycle, recorder);
  queue.Schedule(At(1), EventOrder::kOnboardCycle, recorder);
  EXPECT_DEATH(queue.Schedule(At(1), EventOrder::kOnboardCycle, recorder), "internal error");
}

TEST(EventQueueDeathTest, RefusesAnEventInThePast) {
  EventQueue queue;
  Recorder recorder;
  queue.Schedule(At(10), EventOrder::kOnboardCycle, recorder);
  queue.RunNext();
  EXPECT_DEATH(queue.Schedule(At(9), EventOrder::kOnboardCycle, recorder), "internal error");
}

TEST(EventQueueTest, FillsToItsCapacityAndEmptiesWithoutAllocation) {
  constexpr std::size_t kCapacity = 256;
  EventQueue queue(kCapacity);
  Recorder recorder(kCapacity);
  const test::RealtimeGuard guard;
  for (std::size_t i = 0; i < kCapacity; ++i) {
    const auto ns = static_cast<std::int64_t>(i * 37 % 101);
    queue.Schedule(At(ns), EventOrder::kOnboardCycle, recorder, i);
  }
  RunAll(queue);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(recorder.seen().size(), kCapacity);
}

TEST(EventQueueTest, TellsWhenTheNextEventIsDue) {
  EventQueue queue;
  Recorder recorder;
  EXPECT_EQ(queue.NextTime(), std::nullopt);
  queue.Schedule(At(30), EventOrder::kOnboardCycle, recorder, 3);
  queue.Schedule(At(10), EventOrder::kOnboardCycle, recorder, 1);
  EXPECT_EQ(queue.NextTime(), At(10));
  queue.RunNext();
  EXPECT_EQ(queue.NextTime(), At(30));
}

TEST(EventQueueTest, AdvancesForwardButNeverBeyondTheNextEventAndNeverBack) {
  EventQueue queue;
  Recorder recorder;
  queue.AdvanceTo(At(20));
  EXPECT_EQ(queue.Now(), At(20));
  queue.AdvanceTo(At(5));
  EXPECT_EQ(queue.Now(), At(20));
  queue.Schedule(At(30), EventOrder::kOnboardCycle, recorder, 1);
  queue.AdvanceTo(At(25));
  EXPECT_EQ(queue.Now(), At(25));
  queue.AdvanceTo(At(100));
  EXPECT_EQ(queue.Now(), At(30));
  RunAll(queue);
  EXPECT_THAT(recorder.seen(), ElementsAre(Seen{At(30), 1}));
}

}  // namespace
}  // namespace twin::rt::rt_event_queue_test
