#pragma once

#include <atomic>
#include <cstdint>

#include "twin/core/clock.h"
#include "twin/rt/arrival.h"

namespace twin::rt {

/// Wakes one waiting thread from others: a counter to sleep on (futex) with an absolute deadline,
/// which neither a condition variable without a lock nor std::atomic::wait offers.
///
///     Notify(): count_ + 1, wake         AwaitUntil(): count_ != seen_ ? return : sleep on count_
///
/// Notifications between two waits count as one.
///
/// Threads: Notify() from any, AwaitUntil() from one. Real-time: both noexcept, no allocation, no
/// lock; Notify() makes a system call only if a thread waits.
class Signal final : public Arrival {
 public:
  /// @param clock  deadlines are of this clock; must outlive the signal.
  explicit Signal(const MonotonicClock& clock) : clock_(clock) {}

  void Notify() noexcept TWIN_REALTIME;
  [[nodiscard]] bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME override;

 private:
  const MonotonicClock& clock_;
  std::atomic<std::uint32_t> count_{0};
  std::atomic<bool> waiting_{false};
  std::uint32_t seen_ = 0;
};

}  // namespace twin::rt
