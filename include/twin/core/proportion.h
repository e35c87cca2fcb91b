#pragma once

#include <utility>

namespace twin {

/// 95 % confidence interval of a probability, from `hits` in `trials` (Wilson's score; Wilson
/// 1927). @pre 0 <= hits <= trials, trials > 0.
[[nodiscard]] std::pair<double, double> WilsonInterval(int hits, int trials) noexcept;

}  // namespace twin
