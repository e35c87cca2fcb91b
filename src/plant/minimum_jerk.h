#pragma once

#include <algorithm>

namespace twin::plant {

/// The way and its speed along a path of minimum jerk from 0 to 1, at x of [0, 1].
struct PathPoint {
  double s = 0;
  double ds = 0;  ///< ds/dx
};

/// s = 10 x^3 - 15 x^4 + 6 x^5; x outside [0, 1] is taken for the nearer end.
[[nodiscard]] constexpr PathPoint MinimumJerk(double x) noexcept {
  x = std::clamp(x, 0.0, 1.0);
  return {x * x * x * (10 + x * (-15 + 6 * x)), 30 * x * x * (1 - x) * (1 - x)};
}

}  // namespace twin::plant
