#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/arm_properties.h"

namespace twin::plant {

/// A delay line of one value a cycle, with linear interpolation between cycles. Copies are
/// snapshots.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class TorqueDelay {
 public:
  /// @param delay  in [0, kLongestTorqueDelay].
  explicit TorqueDelay(Duration delay) noexcept
      : cycles_(static_cast<std::size_t>(delay / kCycle)),
        share_(ToSeconds(delay % kCycle) / kCycleSeconds) {}

  /// As if the value had been `tau` for ever.
  void Fill(const JointVector& tau) noexcept TWIN_REALTIME { past_.fill(tau); }

  /// Takes this cycle's value. @returns the late one.
  JointVector Pass(const JointVector& tau) noexcept TWIN_REALTIME {
    newest_ = (newest_ + 1) % past_.size();
    past_[newest_] = tau;
    JointVector late = Ago(cycles_);
    if (share_ == 0) return late;
    const JointVector& before = Ago(cycles_ + 1);
    for (std::size_t i = 0; i < kJoints; ++i) late[i] += share_ * (before[i] - late[i]);
    return late;
  }

 private:
  [[nodiscard]] const JointVector& Ago(std::size_t cycles) const noexcept TWIN_REALTIME {
    return past_[(newest_ + past_.size() - cycles) % past_.size()];
  }

  std::size_t cycles_;  ///< whole ones
  double share_;        ///< of a further cycle, in [0, 1)
  std::array<JointVector, kLongestTorqueDelay / kCycle + 1> past_{};
  std::size_t newest_ = 0;
};

}  // namespace twin::plant
