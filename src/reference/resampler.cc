#include "twin/reference/resampler.h"

#include <algorithm>
#include <cmath>

#include "twin/core/require.h"

namespace twin::reference {
namespace {

constexpr double kT = kCycleSeconds;

/// Lag behind the newest deposit, in periods of the source.
constexpr double kLagPeriods = 2.25;

/// The lock: its low-pass, s; its gains, 1/s and 1/s^2, of a damping of 1; and the fastest that the
/// play time may run away from the robot's.
constexpr double kFilter = 0.2;
constexpr double kProportional = 0.8;
constexpr double kIntegral = 0.16;
constexpr double kMostRate = 5e-3;

/// Periods beyond the last deposit for which the motion is taken to go on as it was.
constexpr double kBeyondPeriods = 3;

/// A lag that is off by more periods than these is not a drift but a jump.
constexpr double kJumpPeriods = 4;

double CheckedPeriod(double source_rate_hz) {
  RequireInRange("resampler: source rate (Hz)", source_rate_hz, 1, 1000);
  return 1 / source_rate_hz;
}

}  // namespace

Resampler::Resampler(double source_rate_hz)
    : lag_s_(kLagPeriods * CheckedPeriod(source_rate_hz)), period_s_(1 / source_rate_hz) {}

void Resampler::Reset(const JointVector& q) noexcept {
  count_ = 1;
  knots_[0] = {0, q};
  first_ = {};
  t_ = 0;
  error_ = 0;
  drift_ = 0;
  rate_ = 0;
  ended_ = true;
}

void Resampler::Deposit(Time source_time, const JointVector& q) noexcept {
  if (first_ == Time()) {
    // Where the motion begins, as if it had been deposited all the while before.
    first_ = source_time;
    knots_[1] = {-period_s_, knots_[0].q};
    knots_[0].t = -2 * period_s_;
    count_ = 2;
    Append({0, q});
    t_ = -lag_s_;
    ended_ = false;
    return;
  }
  const double t = ToSeconds(source_time - first_);
  if (t <= knots_[count_ - 1].t) {
    knots_[count_ - 1].q = q;
    return;
  }
  Append({t, q});
  Lock(t);
}

void Resampler::Append(const Knot& knot) noexcept {
  if (count_ == kKnots) {
    std::move(knots_.begin() + 1, knots_.end(), knots_.begin());
    --count_;
  }
  knots_[count_++] = knot;
}

void Resampler::Lock(double newest) noexcept {
  const double lag = newest - t_;
  if (std::abs(lag - lag_s_) > kJumpPeriods * std::max(period_s_, kT)) {
    t_ = newest - lag_s_;
    error_ = 0;
    return;
  }
  // The lag is seen at a cycle after the arrival: half a cycle late in the mean.
  const double e = lag - lag_s_;
  const double step = std::max(period_s_, kT);
  error_ += std::min(step / kFilter, 1.0) * (e - error_);
  drift_ = std::clamp(drift_ + kIntegral * error_ * step, -kMostRate, kMostRate);
  rate_ = std::clamp(kProportional * error_ + drift_, -kMostRate, kMostRate);
}

JointVector Resampler::Next() noexcept {
  if (first_ != Time()) {
    const double most = knots_[count_ - 1].t + kBeyondPeriods * period_s_;
    t_ = std::min(t_ + kT * (1 + rate_), most);
    ended_ = t_ >= most;
  }
  return ended_ ? knots_[count_ - 1].q : Play();
}

double Resampler::Slope(std::size_t knot, std::size_t joint) const noexcept {
  const auto chord = [&](std::size_t i) {
    return (knots_[i + 1].q[joint] - knots_[i].q[joint]) / (knots_[i + 1].t - knots_[i].t);
  };
  if (knot == 0) return chord(0);
  if (knot + 1 == count_) {  // that of the parabola through the last three
    if (count_ == 2) return chord(0);
    const double last = knots_[knot].t - knots_[knot - 1].t;
    const double before_last = knots_[knot - 1].t - knots_[knot - 2].t;
    const double bend = (chord(knot - 1) - chord(knot - 2)) / (last + before_last);
    return chord(knot - 1) + last * bend;
  }
  const double before = knots_[knot].t - knots_[knot - 1].t;
  const double after = knots_[knot + 1].t - knots_[knot].t;
  return (after * chord(knot - 1) + before * chord(knot)) / (before + after);
}

JointVector Resampler::Beyond() const noexcept {
  const Knot& last = knots_[count_ - 1];
  JointVector q = last.q;
  for (std::size_t j = 0; j < kJoints; ++j) q[j] += (t_ - last.t) * Slope(count_ - 1, j);
  return q;
}

JointVector Resampler::Play() const noexcept {
  if (count_ < 2) return knots_[0].q;
  if (t_ >= knots_[count_ - 1].t) return Beyond();
  if (t_ <= knots_[0].t) return knots_[0].q;
  std::size_t i = count_ - 2;
  while (i > 0 && t_ < knots_[i].t) --i;
  const double h = knots_[i + 1].t - knots_[i].t;
  const double s = (t_ - knots_[i].t) / h;
  JointVector q{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double rise = knots_[i + 1].q[j] - knots_[i].q[j];
    const double a = h * Slope(i, j) - rise;
    const double b = rise - h * Slope(i + 1, j);
    q[j] = knots_[i].q[j] + s * rise + s * (1 - s) * ((1 - s) * a + s * b);
  }
  return q;
}

}  // namespace twin::reference
