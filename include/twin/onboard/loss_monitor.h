#pragma once

#include <bitset>
#include <cstdint>

#include "twin/core/realtime.h"

namespace twin::onboard {

/// Counts the commands of a motion that came and that did not.
///
/// success rate = commands received in the last 100 cycles / number of those cycles. While a motion
/// is younger than 100 cycles the share is of the cycles it has had (the real robot's rule for them
/// is not public). Counting begins with the first command: a client necessarily reads two states
/// after the modes switch before it sends one. Source: FCI protocol 5, packet loss.
///
/// Threads: INT's. Real-time: noexcept, O(1).
class LossMonitor {
 public:
  /// A new motion: nothing counted yet.
  void Reset() noexcept { *this = LossMonitor(); }

  void CountServed() noexcept TWIN_REALTIME {
    Count(true);
    lost_in_row_ = 0;
  }
  void CountLost() noexcept TWIN_REALTIME {
    Count(false);
    ++lost_in_row_;
  }

  /// Cycles without a command since the last served one.
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
