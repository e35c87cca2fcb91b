#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// Spreads the updates of a slow command source evenly over the 1 ms cycles between them.
///
/// A moving average over the last N cycles, N = ceil(f_INT / f_EXT), of position, velocity and
/// acceleration alike:
///   y(k) = (u(k) + u(k-1) + ... + u(k-N+1)) / N,   u(k) = newest target deposited before cycle k.
/// A staircase of step h every N cycles becomes a ramp of h/N a cycle; group delay (N - 1)/2
/// cycles. Averaging the velocity too matters: with the position alone averaged, a reference
/// generator behind it makes jerk 8 ddq/T at N = 8. Source: the paper's section on rate matching.
///
/// Rounding: y(k) is within two units in the last place of the window's largest magnitude, however
/// long it runs; a component that was the same u over the whole window comes out as exactly u. A
/// value that is not finite shows in y and is gone at the latest 2 N cycles after its last deposit.
///
/// Before the first Next(): the value given to Reset(), so that y starts without a step; without a
/// Reset(), zero. When the source stalls, y reaches the last u after N - 1 cycles and stays there.
///
/// Threads: all calls from the tick. Real-time: Next() is noexcept, O(1), allocates nothing.
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
  /// Positions, then velocities, then accelerations.
  static constexpr std::size_t kComponents = 3 * kJoints;
  using Components = std::array<double, kComponents>;

  /// A sum kept as high + low, with the rounding error of each addition (Knuth's two-sum) gathered
  /// in low.
  struct Sum {
    double high = 0;
    double low = 0;
    void Add(double x) noexcept;
  };

  [[nodiscard]] double Average(std::size_t component, double oldest, double newest) noexcept;

  std::vector<Components> window_;  ///< the last N targets, a ring
  std::size_t next_ = 0;            ///< index of the oldest
  /// Sum over the window: the newest added, the oldest subtracted.
  std::array<Sum, kComponents> sums_{};
  /// Sum of what came since next_ was 0. It replaces sums_ when the ring is full again, so nothing
  /// that subtraction leaves behind lives longer than N cycles.
  std::array<Sum, kComponents> fresh_{};
  /// For how many cycles the component has been the same, at most N.
  std::array<std::size_t, kComponents> same_{};
};

}  // namespace twin::reference
