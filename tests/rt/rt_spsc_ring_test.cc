#include "twin/rt/spsc_ring.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

#include "support/effort.h"
#include "support/realtime_guard.h"

namespace twin::rt::rt_spsc_ring_test {
namespace {

/// The oldest value, or -1.
int Pop(SpscRing<int>& ring) {
  int value = -1;
  ring.TryPopWith([&value](const int& oldest) { value = oldest; });
  return value;
}

TEST(SpscRingTest, HandsValuesOverInOrder) {
  SpscRing<int> ring(4);
  EXPECT_TRUE(ring.TryPush(1));
  EXPECT_TRUE(ring.TryPush(2));
  EXPECT_EQ(Pop(ring), 1);
  EXPECT_EQ(Pop(ring), 2);
}

TEST(SpscRingTest, RefusesToPopWhenEmpty) {
  SpscRing<int> ring(2);
  bool used = false;
  EXPECT_FALSE(ring.TryPopWith([&used](const int&) { used = true; }));
  EXPECT_FALSE(used);
}

TEST(SpscRingTest, HoldsItsCapacityThenRefusesAndKeepsWhatItHas) {
  SpscRing<int> ring(4);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.TryPush(i));
  EXPECT_EQ(ring.size(), 4U);
  bool filled = false;
  EXPECT_FALSE(ring.TryPushWith([&filled](int&) { filled = true; }));
  EXPECT_FALSE(filled);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(Pop(ring), i);
  EXPECT_EQ(ring.size(), 0U);
}

TEST(SpscRingTest, KeepsOrderAcrossManyTurns) {
  SpscRing<int> ring(8);
  int pushed = 0;
  int popped = 0;
  for (int round = 0; round < 1000; ++round) {
    for (int i = 0; i < 1 + round % 8; ++i) ASSERT_TRUE(ring.TryPush(pushed++));
    while (popped < pushed) ASSERT_EQ(Pop(ring), popped++);
  }
}

TEST(SpscRingDeathTest, RefusesACapacityThatIsNoPowerOfTwo) {
  EXPECT_DEATH(SpscRing<int>(0), "internal error");
  EXPECT_DEATH(SpscRing<int>(1), "internal error");
  EXPECT_DEATH(SpscRing<int>(6), "internal error");
}

TEST(SpscRingTest, PushesAndPopsWithoutAllocation) {
  SpscRing<int> ring(16);
  const test::RealtimeGuard guard;
  int refused = 0;
  for (int i = 0; i < 1000; ++i) {
    if (!ring.TryPush(i)) ++refused;
    if (i % 3 != 0) Pop(ring);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(refused, 0);
}

/// Wider than any single store, so that a torn value shows.
using Wide = std::array<std::uint64_t, 16>;

TEST(SpscRingStressTest, TwoThreadsLoseDoubleAndTearNothing) {
  constexpr std::uint64_t kValues = test::Repetitions(200'000);
  SpscRing<Wide> ring(64);
  std::thread producer([&ring] {
    for (std::uint64_t i = 0; i < kValues;) {
      if (ring.TryPushWith([i](Wide& slot) { slot.fill(i); })) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t expected = 0;
  std::uint64_t wrong = 0;
  while (expected < kValues) {
    const bool popped = ring.TryPopWith([&](const Wide& value) {
      for (const std::uint64_t word : value) wrong += word != expected ? 1 : 0;
      ++expected;
    });
    if (!popped) std::this_thread::yield();
  }
  producer.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(ring.size(), 0U);
}

}  // namespace
}  // namespace twin::rt::rt_spsc_ring_test
