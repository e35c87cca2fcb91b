#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin {

/// An arm is at rest when none of its joints was measured to be as fast as this, rad/s, ...
inline constexpr double kRestSpeed = 0.05;
/// ... for so long: an arm that swings is slow twice in each of its swings.
inline constexpr Duration kRestTime = std::chrono::milliseconds(100);
/// Within so long after the end of a motion an arm must be at rest. One that is braked from its
/// greatest velocity by its greatest deceleration stands after 0.29 s.
inline constexpr Duration kRestTimeout = std::chrono::seconds(1);

/// The joint that is measured to be the fastest, from 0.
[[nodiscard]] inline std::size_t FastestJoint(const JointVector& dq) noexcept {
  const auto slower = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return static_cast<std::size_t>(std::ranges::max_element(dq, slower) - dq.begin());
}

/// Watches whether an arm comes to rest, on the robot's time: ids of states, one a millisecond. The
/// figures above are decisions; the robot's own are not public.
///
/// Threads: one at a time. Real-time: noexcept, allocates nothing.
class RestWatch {
 public:
  /// From here on the arm may move: nothing is held against it.
  void Restart(std::uint64_t message_id) noexcept TWIN_REALTIME {
    now_ = moved_ = rested_ = message_id;
  }
  /// @param dq  measured, rad/s. What is no number moves.
  void Observe(std::uint64_t message_id, const JointVector& dq) noexcept TWIN_REALTIME {
    now_ = message_id;
    const auto is_slow = [](double x) { return std::abs(x) < kRestSpeed; };
    if (!std::ranges::all_of(dq, is_slow)) moved_ = message_id;
    if (AtRest()) rested_ = message_id;
  }
  /// Whether it is at rest.
  [[nodiscard]] bool AtRest() const noexcept TWIN_REALTIME { return Still() >= kRestTime; }
  /// For how long no joint has been faster.
  [[nodiscard]] Duration Still() const noexcept TWIN_REALTIME {
    return static_cast<std::int64_t>(now_ - moved_) * kCycle;
  }
  /// How long it has not been, or since Restart().
  [[nodiscard]] Duration Restless() const noexcept TWIN_REALTIME {
    return static_cast<std::int64_t>(now_ - rested_) * kCycle;
  }

 private:
  std::uint64_t now_ = 0;
  std::uint64_t moved_ = 0;
  std::uint64_t rested_ = 0;
};

}  // namespace twin
