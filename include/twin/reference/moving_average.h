#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "twin/core/realtime.h"

namespace twin::reference {

/// N = ceil(f_INT / f_EXT), the cycles between two updates of a source.
/// @param source_rate_hz  f_EXT in [1, 1000].
/// @throws InputError naming the value and the range.
[[nodiscard]] std::size_t RateMatchingWindow(double source_rate_hz);

/// Moving average of each component over the last N values:
///   y(k) = (u(k) + u(k-1) + ... + u(k-N+1)) / N.
///
/// Rounding: y(k) is within two units in the last place of the window's largest magnitude, for any
/// run length; a component with the same u over the whole window yields exactly u. A value that is
/// not finite affects y for at most 2 N values.
///
/// Before the first Next() the window holds the value of Reset(), or zeros.
///
/// Threads: one. Real-time: Reset() and Next(); noexcept, no allocation; Next() is O(kComponents).
template <std::size_t kComponents>
class MovingAverage {
 public:
  using Values = std::array<double, kComponents>;

  /// @param window  N >= 1.
  explicit MovingAverage(std::size_t window) : window_(window) { Reset({}); }

  /// @param u0  fills the window.
  void Reset(const Values& u0) noexcept TWIN_REALTIME;

  /// @returns y(k).
  [[nodiscard]] Values Next(const Values& u) noexcept TWIN_REALTIME;

  /// The newest u.
  [[nodiscard]] const Values& last() const noexcept {
    return window_[(next_ + window_.size() - 1) % window_.size()];
  }

  /// N.
  [[nodiscard]] std::size_t window() const noexcept { return window_.size(); }

 private:
  /// A sum as high + low; low collects the rounding errors of the additions (Knuth's two-sum).
  struct Sum {
    double high = 0;
    double low = 0;
    void Add(double x) noexcept;
  };

  [[nodiscard]] double Average(std::size_t component, double oldest, double newest) noexcept;

  std::vector<Values> window_;  ///< the last N values, as a ring
  std::size_t next_ = 0;        ///< index of the oldest
  /// Sum over the window: the newest added, the oldest subtracted.
  std::array<Sum, kComponents> sums_{};
  /// Sum of the values since next_ was 0. It replaces sums_ when the ring has wrapped, so rounding
  /// residue of subtractions lasts at most N cycles.
  std::array<Sum, kComponents> fresh_{};
  /// Cycles since the component changed, at most N.
  std::array<std::size_t, kComponents> same_{};
};

template <std::size_t kComponents>
void MovingAverage<kComponents>::Sum::Add(double x) noexcept {
  const double sum = high + x;
  const double of_x = sum - high;
  low += (high - (sum - of_x)) + (x - of_x);
  high = sum;
}

template <std::size_t kComponents>
void MovingAverage<kComponents>::Reset(const Values& u0) noexcept {
  next_ = 0;
  sums_ = {};
  fresh_ = {};
  same_.fill(window_.size());
  for (Values& slot : window_) {
    slot = u0;
    for (std::size_t i = 0; i < kComponents; ++i) sums_[i].Add(slot[i]);
  }
}

template <std::size_t kComponents>
double MovingAverage<kComponents>::Average(std::size_t component, double oldest,
                                           double newest) noexcept {
  Sum& sum = sums_[component];
  Sum& fresh = fresh_[component];
  fresh.Add(newest);
  if (next_ + 1 == window_.size()) {
    sum = fresh;
    fresh = {};
  } else {
    sum.Add(newest);
    sum.Add(-oldest);
  }
  if (same_[component] == window_.size()) return newest;
  return (sum.high + sum.low) / static_cast<double>(window_.size());
}

template <std::size_t kComponents>
auto MovingAverage<kComponents>::Next(const Values& u) noexcept -> Values {
  const std::size_t size = window_.size();
  const Values& newest = last();
  Values& slot = window_[next_];
  Values y;
  for (std::size_t i = 0; i < kComponents; ++i) {
    same_[i] = u[i] == newest[i] ? std::min(same_[i] + 1, size) : 1;
    y[i] = Average(i, slot[i], u[i]);
    slot[i] = u[i];
  }
  next_ = (next_ + 1) % size;
  return y;
}

}  // namespace twin::reference
