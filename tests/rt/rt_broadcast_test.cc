#include "twin/rt/broadcast.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::rt::rt_broadcast_test {
namespace {

/// Several words that belong together.
struct Pack {
  std::array<std::uint64_t, 12> words{};
  std::uint8_t last = 0;
};

Pack PackOf(std::uint64_t number) {
  Pack pack;
  pack.words.fill(number);
  pack.last = static_cast<std::uint8_t>(number);
  return pack;
}

bool IsWhole(const Pack& pack) {
  for (const std::uint64_t word : pack.words) {
    if (word != pack.words[0]) return false;
  }
  return pack.last == static_cast<std::uint8_t>(pack.words[0]);
}

TEST(BroadcastTest, ShowsWhatItBeganWith) {
  EXPECT_EQ(Broadcast<int>(7).Read(), 7);
}

TEST(BroadcastTest, ShowsTheNewest) {
  Broadcast<Pack> broadcast;
  for (std::uint64_t k = 1; k <= 100; ++k) {
    broadcast.Publish(PackOf(k));
    EXPECT_EQ(broadcast.Read().words[5], k);
    EXPECT_EQ(broadcast.Read().words[5], k) << "as often as it is asked";
  }
}

TEST(BroadcastTest, AllocatesAndLocksNothing) {
  Broadcast<Pack> broadcast;
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    broadcast.Publish(PackOf(k));
    (void)broadcast.Read();
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

TEST(BroadcastTest, ManyReadersSeeWholeValuesThatNeverGoBack) {
  constexpr std::uint64_t kLast = 200'000;
  Broadcast<Pack> broadcast;
  std::atomic<int> torn{0};
  std::atomic<int> backwards{0};
  std::vector<std::jthread> readers;
  readers.reserve(3);
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      for (std::uint64_t seen = 0; seen < kLast;) {
        const Pack pack = broadcast.Read();
        if (!IsWhole(pack)) ++torn;
        if (pack.words[0] < seen) ++backwards;
        seen = pack.words[0];
      }
    });
  }
  for (std::uint64_t k = 1; k <= kLast; ++k) broadcast.Publish(PackOf(k));
  readers.clear();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
}

}  // namespace
}  // namespace twin::rt::rt_broadcast_test
