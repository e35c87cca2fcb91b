#pragma once

#include <cstddef>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/moving_average.h"
#include "twin/reference/target.h"

// Rate matching spreads the updates of a slow command source evenly over the 1 ms cycles between
// them. One class per kind of target; each is a moving average over the last N cycles,
// N = ceil(f_INT / f_EXT):
//   y(k) = (u(k) + u(k-1) + ... + u(k-N+1)) / N,   u(k) = newest target deposited before cycle k.
// A staircase of step h every N cycles becomes a ramp of h/N per cycle; group delay (N - 1)/2
// cycles. The velocity must be averaged too: if only the position is, a reference generator behind
// it produces a jerk of 8 ddq/T at N = 8. When two clocks drift, some updates last N - 1 or N + 1
// cycles, and the ramp has one cycle of double or zero increment: behind a reference generator a
// jerk of ddq/T + lambda dq/T^2, whose first term stays within the Panda's limit up to half the
// acceleration limit. Source: the paper's section on rate matching.
//
// Rounding and values that are not finite: see MovingAverage.
//
// Before the first Next(): the value of Reset(), so that y starts without a step; without Reset(),
// zero (a pose: the identity). When the source stalls, y reaches exactly the last u after N - 1
// cycles and stays there.
//
// Threads: all calls from the tick. Real-time: Reset() and Next(); noexcept, allocate nothing;
// Next() is O(1).
namespace twin::reference {

/// Rate matching of joint targets: position, velocity and acceleration.
class RateMatcher {
 public:
  /// @param source_rate_hz  f_EXT in [1, 1000].
  /// @throws InputError naming the value and the range.
  explicit RateMatcher(double source_rate_hz);

  /// @param u0  target that fills the window.
  void Reset(const JointTarget& u0) noexcept TWIN_REALTIME;

  /// @returns y(k).
  [[nodiscard]] JointTarget Next(const JointTarget& u) noexcept TWIN_REALTIME;

  /// N.
  [[nodiscard]] std::size_t window() const noexcept { return average_.window(); }

 private:
  /// Positions, then velocities, then accelerations.
  MovingAverage<3 * kJoints> average_;
};

/// Rate matching of torques.
class TorqueRateMatcher {
 public:
  /// @param source_rate_hz  f_EXT in [1, 1000].
  /// @throws InputError naming the value and the range.
  explicit TorqueRateMatcher(double source_rate_hz);

  /// @param u0  torque that fills the window, Nm.
  void Reset(const JointVector& u0) noexcept TWIN_REALTIME { average_.Reset(u0); }

  /// @returns y(k), Nm.
  [[nodiscard]] JointVector Next(const JointVector& u) noexcept TWIN_REALTIME {
    return average_.Next(u);
  }

  /// N.
  [[nodiscard]] std::size_t window() const noexcept { return average_.window(); }

 private:
  MovingAverage<kJoints> average_;
};

/// Rate matching of poses: position and twist as above. The rotation is the normalised mean of the
/// window's unit quaternions, each with the sign nearer to its predecessor. A staircase of
/// rotations by h about one axis becomes a ramp of h/N per cycle, up to terms of h^3.
class PoseRateMatcher {
 public:
  /// @param source_rate_hz  f_EXT in [1, 1000].
  /// @throws InputError naming the value and the range.
  explicit PoseRateMatcher(double source_rate_hz);

  /// @param u0  target that fills the window.
  void Reset(const PoseTarget& u0) noexcept TWIN_REALTIME;

  /// @returns y(k); its rotation equals u's bit for bit when the window holds no other.
  [[nodiscard]] PoseTarget Next(const PoseTarget& u) noexcept TWIN_REALTIME;

  /// N.
  [[nodiscard]] std::size_t window() const noexcept { return average_.window(); }

 private:
  /// Position, twist, quaternion (x y z w).
  MovingAverage<13> average_;
};

}  // namespace twin::reference
