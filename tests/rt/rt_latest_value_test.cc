#include "twin/rt/latest_value.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <thread>

#include "support/effort.h"
#include "support/realtime_guard.h"

namespace twin::rt::rt_latest_value_test {
namespace {

TEST(LatestValueTest, IsTheDefaultValueBeforeTheFirstPublish) {
  LatestValue<int> latest;
  EXPECT_FALSE(latest.Refresh());
  EXPECT_FALSE(latest.has_value());
  EXPECT_EQ(latest.value(), 0);
}

TEST(LatestValueTest, ShowsTheNewestAndLosesThoseBetween) {
  LatestValue<int> latest;
  for (int i = 1; i <= 5; ++i) latest.Publish(i);
  EXPECT_TRUE(latest.Refresh());
  EXPECT_EQ(latest.value(), 5);
}

TEST(LatestValueTest, RefreshIsTrueOncePerNewValue) {
  LatestValue<int> latest;
  latest.Publish(1);
  EXPECT_TRUE(latest.Refresh());
  EXPECT_FALSE(latest.Refresh());
  EXPECT_EQ(latest.value(), 1);
  EXPECT_TRUE(latest.has_value());
}

TEST(LatestValueTest, ValueStaysUntilTheNextRefresh) {
  LatestValue<int> latest;
  latest.Publish(1);
  latest.Refresh();
  latest.Publish(2);
  latest.Publish(3);
  EXPECT_EQ(latest.value(), 1);
  EXPECT_TRUE(latest.Refresh());
  EXPECT_EQ(latest.value(), 3);
}

TEST(LatestValueTest, EveryOrderOfTenCallsShowsTheNewest) {
  // Ten calls, each a publish or a refresh as the bit says: all 1024 orders.
  for (unsigned order = 0; order < 1024; ++order) {
    LatestValue<int> latest;
    int published = 0;
    int shown = 0;
    for (unsigned call = 0; call < 10; ++call) {
      if ((order >> call & 1) != 0) {
        latest.Publish(++published);
      } else {
        ASSERT_EQ(latest.Refresh(), shown != published) << "order " << order;
        shown = published;
      }
      ASSERT_EQ(latest.value(), shown) << "order " << order;
    }
  }
}

TEST(LatestValueTest, PublishesAndRefreshesWithoutAllocation) {
  LatestValue<int> latest;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    latest.Publish(i);
    latest.Refresh();
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

/// Wider than any single store, so that a torn value shows.
using Wide = std::array<std::uint64_t, 16>;

TEST(LatestValueStressTest, TwoThreadsSeeWholeValuesInOrderAndTheLastOne) {
  constexpr std::uint64_t kValues = test::Repetitions(200'000);
  const auto latest = std::make_unique<LatestValue<Wide>>();
  std::thread producer([&latest] {
    Wide value;
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      value.fill(i);
      latest->Publish(value);
      if (i % 64 == 0) std::this_thread::yield();
    }
  });
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t last = 0;
  while (last < kValues) {
    if (!latest->Refresh()) {
      std::this_thread::yield();
      continue;
    }
    const Wide& value = latest->value();
    for (const std::uint64_t word : value) torn += word != value.front() ? 1 : 0;
    backwards += value.front() <= last ? 1 : 0;
    last = value.front();
  }
  producer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
}

}  // namespace
}  // namespace twin::rt::rt_latest_value_test
