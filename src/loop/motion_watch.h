#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::loop {

/// Why the workstation's side gave up.
enum class LoopFailure : std::uint8_t {
  kNone,
  kInvalidCommand,  ///< the controller's target made a command that must not be sent
  kConnectionLost,  ///< the backend says the connection is gone
  kException,       ///< the communication thread met an exception
};

/// What the communication side has seen of a motion, for whoever looks on.
///
///     communication side: Observe() --atomics--> onlooker, controller thread
///
/// Each member is a single fact that only rises, stored with release after what led to it and read
/// with acquire.
///
/// Threads: Observe() and Fail() from the communication side, Expect() and End() from the onlooker,
/// the rest from any. Real-time: noexcept, wait-free.
class MotionWatch {
 public:
  /// A motion has been asked for.
  void Expect() noexcept { expected_.store(true, std::memory_order_release); }

  /// A state was read. @returns true when it is the first of the motion.
  bool Observe(bool in_motion, Time now) noexcept TWIN_REALTIME {
    last_state_.store(now.time_since_epoch().count(), std::memory_order_release);
    if (!expected_.load(std::memory_order_acquire)) return false;
    if (in_motion) return !moving_.exchange(true, std::memory_order_acq_rel);
    if (moving_.load(std::memory_order_relaxed)) ended_.store(true, std::memory_order_release);
    return false;
  }

  void Fail(LoopFailure failure) noexcept TWIN_REALTIME {
    LoopFailure none = LoopFailure::kNone;  // the first failure stays
    failure_.compare_exchange_strong(none, failure, std::memory_order_acq_rel);
  }
  /// The motion is over though no state has shown it.
  void End() noexcept { ended_.store(true, std::memory_order_release); }

  [[nodiscard]] bool has_state() const noexcept {
    return last_state_.load(std::memory_order_acquire) != kNever;
  }
  /// @pre has_state()
  [[nodiscard]] Time last_state() const noexcept {
    return Time(Duration(last_state_.load(std::memory_order_acquire)));
  }
  [[nodiscard]] bool expected() const noexcept { return expected_.load(std::memory_order_acquire); }
  [[nodiscard]] bool moving() const noexcept { return moving_.load(std::memory_order_acquire); }
  [[nodiscard]] bool ended() const noexcept { return ended_.load(std::memory_order_acquire); }
  [[nodiscard]] LoopFailure failure() const noexcept {
    return failure_.load(std::memory_order_acquire);
  }

 private:
  static constexpr std::int64_t kNever = -1;

  std::atomic<std::int64_t> last_state_{kNever};
  std::atomic<bool> expected_{false};
  std::atomic<bool> moving_{false};
  std::atomic<bool> ended_{false};
  std::atomic<LoopFailure> failure_{LoopFailure::kNone};
};

}  // namespace twin::loop
