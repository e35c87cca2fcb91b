#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"

namespace twin::reference {

/// What a stalled source's last deposit is taken for, cycle by cycle: its position (or pose) stays,
/// and its velocity, which nobody renews, decays within the limits,
///   b = sat(-w2 v, 0.9 A),   j = sat(w3 (b - a), 0.4 J),   a+ = a + T j,   v+ = v + T a+,
/// from a = 0, since a deposit that is not renewed has not changed its velocity. A torque decays by
/// a tenth in 10 ms, at most 870 Nm/s of a Panda's 1000. Source: our decision; the paper says that
/// a stalled stream decays gracefully.
///
/// Where the robot's reference is driven by the velocity, this keeps it legal; where it is not, as
/// in a stream of positions, nothing does. When the source returns its deposits count again at
/// once: what that makes of the reference, the limiter or the filter behind takes away.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class StallDecay {
 public:
  /// Where limits are zero, velocities stay.
  StallDecay(const JointLimits& joints, const CartesianLimits& cartesian) noexcept;

  /// The source is not stalled: this is its target.
  void Follow(const Target& target) noexcept TWIN_REALTIME;
  /// The source is stalled: one cycle on.
  void Decay() noexcept TWIN_REALTIME;

  [[nodiscard]] const Target& target() const noexcept { return target_; }

 private:
  std::array<CartesianBound, kJoints> joints_{};
  CartesianLimits cartesian_;
  Target target_;
  JointVector ddq_{};
  Vector6 O_ddP_EE_{};
};

}  // namespace twin::reference
