#include "twin/rt/duration_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace twin::rt {

/// Up to 2^9 ns a bin per value; from there on [2^e, 2^(e+1)) has 2^8 bins of width 2^(e-8).
std::size_t DurationHistogram::BinOf(std::uint64_t ns) noexcept {
  const int shift = std::max(0, static_cast<int>(std::bit_width(ns)) - 1 - kSubBits);
  return (static_cast<std::size_t>(shift) << kSubBits) + (ns >> shift);
}

/// Largest value of a bin.
std::uint64_t DurationHistogram::UpperEdge(std::size_t bin) noexcept {
  const std::size_t power = bin >> kSubBits;
  const std::size_t shift = power == 0 ? 0 : power - 1;
  return ((bin - (shift << kSubBits) + 1) << shift) - 1;
}

void DurationHistogram::Add(Duration value) noexcept {
  const Duration kept = std::clamp(value, Duration{}, Duration(std::int64_t{1} << kMostBits));
  ++bins_[BinOf(static_cast<std::uint64_t>(kept.count()))];
  ++count_;
  min_ = std::min(min_, kept);
  max_ = std::max(max_, kept);
}

Duration DurationHistogram::Percentile(double share) const noexcept {
  const double wanted = std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_));
  const std::uint64_t rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= rank) return std::min(Duration(UpperEdge(bin)), max_);
  }
  return max_;
}

}  // namespace twin::rt
