#pragma once

#include <bitset>
#include <cstdint>

#include "twin/core/realtime.h"

namespace twin::onboard {

/// Counts the received and the lost commands of a motion.
///
/// success rate = commands received in the last 100 cycles / 100. For a motion younger than 100
/// cycles the divisor is its age (the real robot's rule is not public). Counting starts with the
/// first command, because a client reads two states after the mode switch before it sends one.
/// Source: FCI protocol 5, packet loss.
///
/// Threads: INT's. Real-time: noexcept, O(1).
class LossMonitor {
 public:
  /// Clears all counts for a new motion.
  void Reset() noexcept { *this = LossMonitor(); }

  void CountServed() noexcept TWIN_REALTIME {
    Count(true);
    lost_in_row_ = 0;
  }
  void CountLost() noexcept TWIN_REALTIME {
    Count(false);
    ++lost_in_row_;
  }

  /// Cycles without a command since the last command that counted.
  [[nodiscard]] std::uint32_t lost_in_row() const noexcept { return lost_in_row_; }

  /// In [0, 1]; 0 before the first command.
  [[nodiscard]] double success_rate() const noexcept {
    return counted_ == 0 ? 0.0 : static_cast<double>(received_) / static_cast<double>(counted_);
  }

 private:
  static constexpr std::size_t kWindow = 100;

  void Count(bool served) noexcept {
    received_ += served ? 1 : 0;
    if (counted_ == kWindow) {
      received_ -= window_[next_] ? 1 : 0;
    } else {
      ++counted_;
    }
    window_[next_] = served;
    next_ = (next_ + 1) % kWindow;
  }

  std::bitset<kWindow> window_;
  std::size_t next_ = 0;
  std::size_t counted_ = 0;
  std::size_t received_ = 0;
  std::uint32_t lost_in_row_ = 0;
};

}  // namespace twin::onboard
