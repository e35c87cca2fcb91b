#pragma once

#include <atomic>
#include <cstdint>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Lets one thread wait for data: a state from another thread, or a packet at a socket. The
/// communication thread waits nowhere else.
///
/// Threads: one waits. Real-time: bounded by the deadline; allocates nothing, takes no lock.
class Arrival {
 public:
  virtual ~Arrival() = default;

  /// Waits until something arrives that no earlier call has reported, or until `deadline`.
  /// @returns whether something has arrived.
  [[nodiscard]] virtual bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME = 0;
};

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
