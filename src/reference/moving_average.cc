#include "twin/reference/moving_average.h"

#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::reference {

std::size_t RateMatchingWindow(double source_rate_hz) {
  constexpr double kCycleRateHz = 1 / kCycleSeconds;
  if (!(source_rate_hz >= 1 && source_rate_hz <= kCycleRateHz)) {
    throw InputError(fmt::format("rate matcher: the source's rate is {} Hz; it must lie in [1, {}]",
                                 source_rate_hz, kCycleRateHz));
  }
  // Rates like 1000/3 Hz are inexact in binary: slightly above an integer is that integer.
  constexpr double kHair = 1e-9;
  return static_cast<std::size_t>(std::ceil(kCycleRateHz / source_rate_hz - kHair));
}

}  // namespace twin::reference
