#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "twin/core/realtime.h"

namespace twin::rt {

/// Passes the newest value of one producer thread to one consumer thread; intermediate values are
/// lost by design.
///
///     producer owns  slots_[back]          consumer owns  slots_[front]
///                        \                     /
///                         exchange with middle_ (2 bits: slot, 1 bit: fresh)
///
/// Three slots, one atomic exchange per call (acquire-release: the slot's content travels with its
/// number). Neither side ever waits for the other, and neither sees a half-written value.
///
/// Threads: producer-consumer pair. Real-time: wait-free, noexcept, no allocation.
template <typename T>
class LatestValue {
 public:
  /// Producer. Publishes `value`.
  void Publish(const T& value) noexcept TWIN_REALTIME {
    PublishWith([&value](T& slot) { slot = value; });
  }

  /// Producer. As Publish, but `fill(T&)` writes the slot in place, which still holds an old value.
  template <typename Fill>
  void PublishWith(Fill&& fill) noexcept TWIN_REALTIME {
    fill(slots_[back_]);
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) &
            kSlot;
  }

  /// Consumer. @returns true if something was published since the last call; value() is then the
  /// newest.
  bool Refresh() noexcept TWIN_REALTIME {
    if ((middle_.load(std::memory_order_acquire) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kSlot;
    seen_ = true;
    return true;
  }

  /// Consumer. The value of the last Refresh() that returned true; before the first one, T{}.
  [[nodiscard]] const T& value() const noexcept { return slots_[front_]; }

  /// Consumer. Whether Refresh() ever returned true.
  [[nodiscard]] bool has_value() const noexcept { return seen_; }

 private:
  static constexpr std::uint8_t kSlot = 3;
  static constexpr std::uint8_t kFresh = 4;
  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;
  alignas(64) std::uint8_t front_ = 2;
  bool seen_ = false;
};

}  // namespace twin::rt
