#pragma once

#include <cstddef>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// Spreads the updates of a slow command source evenly over the 1 ms cycles between them.
///
/// A moving average over the last N cycles, N = ceil(f_INT / f_EXT), of position and velocity
/// alike:
///   y(k) = (u(k) + u(k-1) + ... + u(k-N+1)) / N,   u(k) = newest target deposited before cycle k.
/// A staircase of step h every N cycles becomes a ramp of h/N a cycle; group delay (N - 1)/2
/// cycles. Averaging the velocity too matters: with the position alone averaged, a reference
/// generator behind it makes jerk 8 ddq/T at N = 8. Source: the paper's section on rate matching.
///
/// Before the first Next(): the value given to Reset(), so that y starts without a step. When the
/// source stalls, y reaches the last u after N - 1 cycles and stays there.
///
/// Threads: all calls from the tick. Real-time: Next() is noexcept, O(N) at most and free of drift,
/// allocates nothing.
class RateMatcher {
 public:
  /// @param source_rate_hz  f_EXT in [1, 1000].
  /// @throws InputError naming the value and the range.
  explicit RateMatcher(double source_rate_hz);

  /// @param u0  target that fills the window.
  void Reset(const JointTarget& u0) noexcept;

  /// @returns y(k).
  [[nodiscard]] JointTarget Next(const JointTarget& u) noexcept TWIN_REALTIME;

  /// N.
  [[nodiscard]] std::size_t window() const noexcept { return window_.size(); }

 private:
  std::vector<JointTarget> window_;
  std::size_t next_ = 0;
};

}  // namespace twin::reference
