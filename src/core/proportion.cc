#include "twin/core/proportion.h"

#include <algorithm>
#include <cmath>

namespace twin {

std::pair<double, double> WilsonInterval(int hits, int trials) noexcept {
  constexpr double kZ = 1.959963984540054;  // of the normal distribution, 95 %
  const double n = trials;
  const double p = hits / n;
  const double centre = (p + kZ * kZ / (2 * n)) / (1 + kZ * kZ / n);
  const double half = kZ * std::sqrt(p * (1 - p) / n + kZ * kZ / (4 * n * n)) / (1 + kZ * kZ / n);
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

}  // namespace twin
