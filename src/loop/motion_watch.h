#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::loop {

/// Failure of the workstation's side.
enum class LoopFailure : std::uint8_t {
  kNone,
  kInvalidCommand,  ///< the controller's target gave a command that must not be sent
  kLimit,           ///< the tick stopped the arm before a limit of the lab
  kConnectionLost,  ///< the backend reports that the connection is lost
  kException,       ///< the communication thread caught an exception
};

/// Progress of a motion as observed by the communication side, for other threads.
///
///     communication side: Observe() --atomics--> supervisor, controller thread
///
/// Each member is a single fact that never falls back. It is stored with release after its cause
/// and read with acquire.
///
/// Threads: Observe() and Fail() from the communication side, Expect() and End() from the
/// supervisor (MotionRunner), the rest from any. Real-time: noexcept, wait-free.
class MotionWatch {
 public:
  /// A motion has been requested.
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
    LoopFailure none = LoopFailure::kNone;  // keeps the first failure
    failure_.compare_exchange_strong(none, failure, std::memory_order_acq_rel);
  }
  /// The motion has ended, though no state has shown its end.
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
