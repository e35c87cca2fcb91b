#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "twin/record/cycle_record.h"
#include "twin/rt/spsc_ring.h"

namespace twin::ros2 {

/// Passes a robot's records on, and keeps those of cycles for a reader on another thread.
///
/// Threads: Put() as RecordSink; TryPop() one. Real-time: Put() allocates and waits for nothing;
/// records that nobody takes in time are dropped and counted.
class StateTap final : public record::RecordSink {
 public:
  /// @param next  may be null; must outlive this.
  explicit StateTap(record::RecordSink* next) : next_(next), ring_(kCycles) {}

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override {
    last_at_.store(record.at, std::memory_order_relaxed);  // publishes nothing else
    if (!ring_.TryPush(record)) dropped_.fetch_add(1, std::memory_order_relaxed);  // a count
    if (next_ != nullptr) next_->Put(record);
  }
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override {
    if (next_ != nullptr) next_->Put(record);
  }

  /// Calls `use(const record::CycleRecord&)` on the oldest. @returns false if there is none.
  template <typename Use>
  bool TryPop(Use&& use) {
    return ring_.TryPopWith(use);
  }
  /// Of the last cycle, whether it was taken or not. Threads: any, as the next.
  [[nodiscard]] Time last_at() const noexcept { return last_at_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr std::size_t kCycles = 256;

  record::RecordSink* const next_;
  rt::SpscRing<record::CycleRecord> ring_;
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<Time> last_at_{};
};

}  // namespace twin::ros2
