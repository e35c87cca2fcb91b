#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "twin/core/realtime.h"

namespace twin::rt {

/// Passes the newest value of one producer thread to any number of threads; intermediate values are
/// lost by design. (LatestValue, for one consumer, avoids a copy.)
///
///     producer: write slot n mod 8,        reader: n = count_, copy slot n mod 8,
///               then count_ = n                    accept if count_ is still below n + 7
///
/// The producer never waits. A reader repeats its copy only if seven publications happen during it.
/// The words of a slot are atomic: stored with release, loaded with acquire, so a reader that sees
/// a word of publication n + 8 also sees count_ = n + 7 and discards its copy.
///
/// Threads: one publishes, any reads. Real-time: noexcept, no allocation; Publish() is wait-free,
/// Read() lock-free.
template <typename T>
class Broadcast {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// @param first  value before the first Publish().
  explicit Broadcast(const T& first = T{}) noexcept { Write(first, 0); }

  void Publish(const T& value) noexcept TWIN_REALTIME {
    const std::uint64_t next = count_.load(std::memory_order_relaxed) + 1;  // the only writer
    Write(value, next);
    count_.store(next, std::memory_order_release);
  }

  [[nodiscard]] T Read() const noexcept TWIN_REALTIME {
    Words words;
    while (true) {
      const std::uint64_t seen = count_.load(std::memory_order_acquire);
      const Slot& slot = slots_[seen % kSlots];
      for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
      if (count_.load(std::memory_order_relaxed) - seen < kSlots - 1) break;
    }
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

 private:
  static constexpr std::size_t kSlots = 8;
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, kWords>;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;

  void Write(const T& value, std::uint64_t number) noexcept {
    Words words{};
    std::memcpy(words.data(), &value, sizeof(T));
    Slot& slot = slots_[number % kSlots];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
  }

  std::array<Slot, kSlots> slots_{};
  alignas(64) std::atomic<std::uint64_t> count_{0};
};

}  // namespace twin::rt
