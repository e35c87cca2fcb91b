#include "support/realtime_guard.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <thread>
#include <vector>

namespace twin::test::realtime_guard_test {
namespace {

using Counts = RealtimeGuard::Counts;

/// Keeps the compiler from leaving out an allocation nobody reads.
void Use(const void* memory) {
  asm volatile("" : : "g"(memory) : "memory");
}

TEST(RealtimeGuardTest, CountsNothingWhileNothingHappens) {
  const RealtimeGuard guard;
  double sum = 0;
  for (int i = 0; i < 1000; ++i) sum += i;
  Use(&sum);
  EXPECT_EQ(guard.counts(), Counts{});
}

TEST(RealtimeGuardTest, FiresOnNewAndDelete) {
  const RealtimeGuard guard;
  auto value = std::make_unique<int>(1);
  Use(value.get());
  const Counts while_alive = guard.counts();
  value.reset();
  const Counts after = guard.counts();
  EXPECT_EQ(while_alive, (Counts{.allocations = 1}));
  EXPECT_EQ(after, (Counts{.allocations = 1, .frees = 1}));
}

TEST(RealtimeGuardTest, FiresOnMallocCallocReallocAndFree) {
  const RealtimeGuard guard;
  void* memory = std::malloc(16);
  Use(memory);
  const std::int64_t after_malloc = guard.allocations();
  memory = std::realloc(memory, 1 << 20);
  Use(memory);
  const std::int64_t after_realloc = guard.allocations();
  std::free(memory);
  void* zeroed = std::calloc(4, 4);
  Use(zeroed);
  std::free(zeroed);
  const Counts counts = guard.counts();
  EXPECT_EQ(after_malloc, 1);
  EXPECT_EQ(after_realloc, 2);
  EXPECT_EQ(counts.allocations, 3);
  EXPECT_GE(counts.frees, 2);  // a realloc that moves may count as a free of the old place
}

TEST(RealtimeGuardTest, FiresOnAlignedAllocation) {
  struct alignas(128) Aligned {
    char bytes[128];
  };
  const RealtimeGuard guard;
  auto value = std::make_unique<Aligned>();
  Use(value.get());
  value.reset();
  EXPECT_EQ(guard.counts(), (Counts{.allocations = 1, .frees = 1}));
}

TEST(RealtimeGuardTest, FiresInsideTheStandardLibrary) {
  const RealtimeGuard guard;
  std::string text;
  text.append(100, 'x');  // compiled into libstdc++, not into this program
  Use(text.data());
  EXPECT_GE(guard.allocations(), 1);
}

TEST(RealtimeGuardTest, FiresOnMutex) {
  std::mutex mutex;
  const RealtimeGuard guard;
  { const std::lock_guard lock(mutex); }
  EXPECT_EQ(guard.counts(), (Counts{.locks = 1}));
}

TEST(RealtimeGuardTest, FiresOnSharedMutexOfEitherKind) {
  std::shared_mutex mutex;
  const RealtimeGuard guard;
  { const std::shared_lock lock(mutex); }
  { const std::unique_lock lock(mutex); }
  EXPECT_EQ(guard.counts(), (Counts{.locks = 2}));
}

TEST(RealtimeGuardTest, LeavesTryLockUncounted) {
  std::mutex mutex;
  const RealtimeGuard guard;
  const bool locked = mutex.try_lock();
  const Counts counts = guard.counts();
  mutex.unlock();
  EXPECT_TRUE(locked);
  EXPECT_EQ(counts, Counts{});
}

TEST(RealtimeGuardTest, LeavesFreeOfNullUncounted) {
  const RealtimeGuard guard;
  std::free(nullptr);
  EXPECT_EQ(guard.frees(), 0);
}

TEST(RealtimeGuardTest, CountsOnlyItsOwnThread) {
  std::int64_t seen_by_other = -1;
  std::vector<int> kept;
  const auto work = [&] {
    const RealtimeGuard other;
    kept.resize(1000);
    seen_by_other = other.allocations();
  };
  const RealtimeGuard before;
  std::thread thread(work);  // allocates, on this thread
  const std::int64_t to_start = before.allocations();
  const RealtimeGuard guard;
  thread.join();
  const std::int64_t here = guard.allocations();
  EXPECT_GE(to_start, 1);
  EXPECT_EQ(seen_by_other, 1);
  EXPECT_EQ(here, 0);
}

TEST(RealtimeGuardTest, GuardsCountFromTheirOwnStart) {
  const RealtimeGuard outer;
  auto first = std::make_unique<int>(1);
  const RealtimeGuard inner;
  auto second = std::make_unique<int>(2);
  Use(first.get());
  Use(second.get());
  const Counts of_outer = outer.counts();
  const Counts of_inner = inner.counts();
  EXPECT_EQ(of_outer.allocations, 2);
  EXPECT_EQ(of_inner.allocations, 1);
}

}  // namespace
}  // namespace twin::test::realtime_guard_test
