#include "twin/rt/signal.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "rt/absolute_time.h"

namespace twin::rt {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t) &&
                  std::atomic<std::uint32_t>::is_always_lock_free,
              "the kernel compares the counter as a bare 32-bit word");

/// Sleeps while `count` is `value`, at most until the absolute CLOCK_MONOTONIC time `until`.
/// @returns false when that time has come.
bool SleepWhile(const std::atomic<std::uint32_t>& count, std::uint32_t value,
                const timespec& until) noexcept {
  const auto result = syscall(SYS_futex, &count, FUTEX_WAIT_BITSET_PRIVATE, value, &until, nullptr,
                              FUTEX_BITSET_MATCH_ANY);
  return result == 0 || errno != ETIMEDOUT;
}

}  // namespace

void Signal::Notify() noexcept {
  // Sequentially consistent, as are the waiter's store of waiting_ and load of count_ behind it: of
  // "count, then look for a waiter" here and "announce, then look at the count" there, at least one
  // sees the other. As a release it also makes visible what was written before.
  count_.fetch_add(1, std::memory_order_seq_cst);
  if (!waiting_.load(std::memory_order_seq_cst)) return;
  syscall(SYS_futex, &count_, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

bool Signal::AwaitUntil(Time deadline) noexcept {
  // Acquire: what was written before a Notify() that is counted is visible.
  std::uint32_t count = count_.load(std::memory_order_acquire);
  if (count == seen_) {
    const timespec until = AbsoluteTime(clock_, deadline);
    waiting_.store(true, std::memory_order_seq_cst);
    count = count_.load(std::memory_order_seq_cst);
    // Woken, interrupted or spuriously returned: only the count tells whether anything came.
    while (count == seen_ && SleepWhile(count_, seen_, until)) {
      count = count_.load(std::memory_order_acquire);
    }
    count = count_.load(std::memory_order_acquire);
    // Relaxed: a notifier that still sees true makes one system call for nothing.
    waiting_.store(false, std::memory_order_relaxed);
  }
  const bool notified = count != seen_;
  seen_ = count;
  return notified;
}

}  // namespace twin::rt
