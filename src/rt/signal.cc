#include "twin/rt/signal.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "twin/rt/host_time.h"

namespace twin::rt {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t) &&
                  std::atomic<std::uint32_t>::is_always_lock_free,
              "the kernel compares the counter as a bare 32-bit word");

/// Sleeps while `count` is `value`, at most until the absolute CLOCK_MONOTONIC time `until`.
/// @returns false at `until`.
bool SleepWhile(const std::atomic<std::uint32_t>& count, std::uint32_t value,
                const timespec& until) noexcept {
  const auto result = syscall(SYS_futex, &count, FUTEX_WAIT_BITSET_PRIVATE, value, &until, nullptr,
                              FUTEX_BITSET_MATCH_ANY);
  return result == 0 || errno != ETIMEDOUT;
}

}  // namespace

void Signal::Notify() noexcept {
  // Sequentially consistent, like the waiter's store of waiting_ and later load of count_: of
  // "count, then check for a waiter" here and "announce, then check the count" there, at least one
  // sees the other. As a release it also publishes earlier writes.
  count_.fetch_add(1, std::memory_order_seq_cst);
  if (!waiting_.load(std::memory_order_seq_cst)) return;
  syscall(SYS_futex, &count_, FUTEX_WAKE_PRIVATE, 1, nullptr, nullptr, 0);
}

bool Signal::AwaitUntil(Time deadline) noexcept {
  // Acquire: makes writes before a counted Notify() visible.
  std::uint32_t count = count_.load(std::memory_order_acquire);
  if (count == seen_) {
    const timespec until = AbsoluteTime(clock_, deadline);
    waiting_.store(true, std::memory_order_seq_cst);
    count = count_.load(std::memory_order_seq_cst);
    // Woken, interrupted or spurious: only the count tells whether data arrived.
    while (count == seen_ && SleepWhile(count_, seen_, until)) {
      count = count_.load(std::memory_order_acquire);
    }
    count = count_.load(std::memory_order_acquire);
    // Relaxed: a notifier that still sees true only makes a needless system call.
    waiting_.store(false, std::memory_order_relaxed);
  }
  const bool notified = count != seen_;
  seen_ = count;
  return notified;
}

}  // namespace twin::rt
