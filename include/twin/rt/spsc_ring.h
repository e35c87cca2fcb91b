#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "twin/core/error.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Queue from one producer thread to one consumer thread, in order, without locks.
///
///     consumer: head_ ->[ v | v | v |   |   ]<- tail_ :producer
///
/// The producer writes the slot, then publishes tail_ (release); the consumer reads tail_
/// (acquire), takes the slot, then frees it by publishing head_ (release), which the producer reads
/// (acquire) before it writes there again.
///
/// Threads: producer-consumer pair. Real-time: TryPush() and TryPop() are noexcept, wait-free and
/// allocate nothing; the constructor allocates and touches the storage. A full ring rejects values;
/// the caller waits or drops.
template <typename T>
class SpscRing {
 public:
  /// @param capacity  number of values, a power of two.
  explicit SpscRing(std::size_t capacity)
      : mask_(capacity - 1), slots_(std::make_unique<T[]>(capacity)) {
    TWIN_CHECK(capacity >= 2 && (capacity & mask_) == 0);
  }

  /// Producer. @returns false, with nothing written, when the ring is full.
  [[nodiscard]] bool TryPush(const T& value) noexcept TWIN_REALTIME {
    return TryPushWith([&value](T& slot) { slot = value; });
  }

  /// Producer. As TryPush, but `fill(T&)` writes the slot in place, which still holds an old value.
  template <typename Fill>
  [[nodiscard]] bool TryPushWith(Fill&& fill) noexcept TWIN_REALTIME {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) > mask_) return false;
    fill(slots_[tail & mask_]);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. Calls `use(const T&)` on the oldest value, then frees it. @returns false if the ring
  /// is empty.
  template <typename Use>
  bool TryPopWith(Use&& use) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (tail_.load(std::memory_order_acquire) == head) return false;
    use(static_cast<const T&>(slots_[head & mask_]));
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Either side; exact only while the other side is idle.
  [[nodiscard]] std::size_t size() const noexcept {
    return tail_.load(std::memory_order_acquire) - head_.load(std::memory_order_acquire);
  }

 private:
  const std::size_t mask_;
  std::unique_ptr<T[]> slots_;
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace twin::rt
