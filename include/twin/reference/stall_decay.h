#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"

namespace twin::reference {

/// Target after a source has stalled, cycle by cycle: its position (or pose) stays, and its
/// velocity decays within the limits,
///   b = sat(-w2 v, 0.9 A),   j = sat(w3 (b - a), 0.4 J),   a+ = a + T j,   v+ = v + T a+,
/// from a = 0, since without new deposits the velocity was constant. A torque decays by a tenth in
/// 10 ms, at most 870 Nm/s of a Panda's 1000. Source: decision; the paper says that a stalled
/// stream decays gracefully.
///
/// This keeps the robot's reference legal where the velocity drives it, but not in a stream of
/// positions. New deposits of a resumed source count at once; the limiter or filter behind smooths
/// the step they cause.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class StallDecay {
 public:
  /// Velocities with zero limits do not decay.
  StallDecay(const JointLimits& joints, const CartesianLimits& cartesian) noexcept;

  /// The target of a source that is not stalled.
  void Follow(const Target& target) noexcept TWIN_REALTIME;
  /// One cycle of a stalled source.
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
