#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Percentiles of very many durations in fixed memory: bin widths grow with the value, 256 bins per
/// power of two, so a percentile is exact within 0.4 %. Minimum, maximum and count are exact.
///
/// Values below 0 count as 0, those above 2^40 ns (18 minutes) as 2^40 ns.
///
/// Threads: one (copies for others). Real-time: Add() is noexcept, O(1), allocates nothing.
class DurationHistogram {
 public:
  void Add(Duration value) noexcept TWIN_REALTIME;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// 0 if empty.
  [[nodiscard]] Duration min() const noexcept { return count_ == 0 ? Duration{} : min_; }
  [[nodiscard]] Duration max() const noexcept { return max_; }

  /// Upper edge of the first bin with at least `share` of all values at or below it, never above
  /// max(); 0 if empty.
  /// @param share  in [0, 1]: 0.5 the median.
  [[nodiscard]] Duration Percentile(double share) const noexcept;

  void Reset() noexcept { *this = DurationHistogram(); }

 private:
  static constexpr int kSubBits = 8;    ///< 2^8 bins per power of two
  static constexpr int kMostBits = 40;  ///< 2^40 ns is the largest value
  static constexpr std::size_t kBins = std::size_t{kMostBits - kSubBits + 2} << kSubBits;

  static std::size_t BinOf(std::uint64_t ns) noexcept;
  static std::uint64_t UpperEdge(std::size_t bin) noexcept;

  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  Duration min_ = Duration::max();
  Duration max_{};
};

}  // namespace twin::rt
