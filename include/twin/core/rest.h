#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin {

/// An arm is at rest when every measured joint velocity is below this, rad/s, ...
inline constexpr double kRestSpeed = 0.05;
/// ... for this long, since a swinging arm is slow twice per period.
inline constexpr Duration kRestTime = std::chrono::milliseconds(100);
/// Time limit for an arm to come to rest after a motion. Braked from its largest velocity by its
/// largest deceleration it stops after 0.29 s.
inline constexpr Duration kRestTimeout = std::chrono::seconds(1);

/// Joint with the largest measured velocity, from 0.
[[nodiscard]] inline std::size_t FastestJoint(const JointVector& dq) noexcept {
  const auto slower = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return static_cast<std::size_t>(std::ranges::max_element(dq, slower) - dq.begin());
}

/// Watches whether an arm comes to rest, in the robot's time (state ids, one per ms). The figures
/// above are decisions; the robot's are not public.
///
/// Threads: one at a time. Real-time: noexcept, allocates nothing.
class RestWatch {
 public:
  /// Restarts the watch: the arm may move from here on.
  void Restart(std::uint64_t message_id) noexcept TWIN_REALTIME {
    now_ = moved_ = rested_ = message_id;
  }
  /// @param dq  measured, rad/s. NaN counts as motion.
  void Observe(std::uint64_t message_id, const JointVector& dq) noexcept TWIN_REALTIME {
    now_ = message_id;
    const auto is_slow = [](double x) { return std::abs(x) < kRestSpeed; };
    if (!std::ranges::all_of(dq, is_slow)) moved_ = message_id;
    if (AtRest()) rested_ = message_id;
  }
  /// Whether it is at rest.
  [[nodiscard]] bool AtRest() const noexcept TWIN_REALTIME { return Still() >= kRestTime; }
  /// Time since a joint was last faster.
  [[nodiscard]] Duration Still() const noexcept TWIN_REALTIME {
    return static_cast<std::int64_t>(now_ - moved_) * kCycle;
  }
  /// Time since the arm was last at rest, or since Restart().
  [[nodiscard]] Duration Restless() const noexcept TWIN_REALTIME {
    return static_cast<std::int64_t>(now_ - rested_) * kCycle;
  }

 private:
  std::uint64_t now_ = 0;
  std::uint64_t moved_ = 0;
  std::uint64_t rested_ = 0;
};

}  // namespace twin
