#pragma once

#include <algorithm>

namespace twin::plant {

/// Position and derivative of the minimum-jerk path from 0 to 1, at x in [0, 1].
struct PathPoint {
  double s = 0;
  double ds = 0;  ///< ds/dx
};

/// s = 10 x^3 - 15 x^4 + 6 x^5; x is clamped to [0, 1].
[[nodiscard]] constexpr PathPoint MinimumJerk(double x) noexcept {
  x = std::clamp(x, 0.0, 1.0);
  return {x * x * x * (10 + x * (-15 + 6 * x)), 30 * x * x * (1 - x) * (1 - x)};
}

}  // namespace twin::plant
