#include "twin/reference/rate_matcher.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::reference {
namespace {

std::size_t WindowOf(double source_rate_hz) {
  constexpr double kCycleRateHz = 1 / kCycleSeconds;
  if (!(source_rate_hz >= 1 && source_rate_hz <= kCycleRateHz)) {
    throw InputError(fmt::format("rate matcher: the source's rate is {} Hz; it must lie in [1, {}]",
                                 source_rate_hz, kCycleRateHz));
  }
  // A rate like 1000/3 Hz is not exact in binary: a hair above a whole ratio is that ratio.
  constexpr double kHair = 1e-9;
  return static_cast<std::size_t>(std::ceil(kCycleRateHz / source_rate_hz - kHair));
}

}  // namespace

RateMatcher::RateMatcher(double source_rate_hz) : window_(WindowOf(source_rate_hz)) {
  Reset({});
}

void RateMatcher::Sum::Add(double x) noexcept {
  const double sum = high + x;
  const double of_x = sum - high;
  low += (high - (sum - of_x)) + (x - of_x);
  high = sum;
}

void RateMatcher::Reset(const JointTarget& u0) noexcept {
  next_ = 0;
  sums_ = {};
  fresh_ = {};
  same_.fill(window_.size());
  for (Components& slot : window_) {
    std::copy(u0.q.begin(), u0.q.end(), slot.begin());
    std::copy(u0.dq.begin(), u0.dq.end(), slot.begin() + kJoints);
    std::copy(u0.ddq.begin(), u0.ddq.end(), slot.begin() + 2 * kJoints);
    for (std::size_t i = 0; i < kComponents; ++i) sums_[i].Add(slot[i]);
  }
}

double RateMatcher::Average(std::size_t component, double oldest, double newest) noexcept {
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

JointTarget RateMatcher::Next(const JointTarget& u) noexcept {
  const std::size_t size = window_.size();
  const Components& last = window_[(next_ + size - 1) % size];
  Components& slot = window_[next_];
  const auto filter = [&](const JointVector& in, std::size_t first, JointVector& out) {
    for (std::size_t j = 0; j < kJoints; ++j) {
      const std::size_t i = first + j;
      same_[i] = in[j] == last[i] ? std::min(same_[i] + 1, size) : 1;
      out[j] = Average(i, slot[i], in[j]);
      slot[i] = in[j];
    }
  };
  JointTarget y;
  filter(u.q, 0, y.q);
  filter(u.dq, kJoints, y.dq);
  filter(u.ddq, 2 * kJoints, y.ddq);
  next_ = (next_ + 1) % size;
  return y;
}

}  // namespace twin::reference
