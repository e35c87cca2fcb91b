#include "twin/reference/resampler.h"

#include <algorithm>
#include <cmath>

#include "twin/core/error.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

/// Lag behind the newest deposit, in periods of the source.
constexpr double kLagPeriods = 2.25;

/// Phase lock: its low-pass, s; its gains, 1/s and 1/s^2, for a damping ratio of 1; and the largest
/// relative rate error of the play time.
constexpr double kFilter = 0.2;
constexpr double kProportional = 0.8;
constexpr double kIntegral = 0.16;
constexpr double kMostRate = 5e-3;

/// Deposits between the support points of the extrapolating parabola: wide enough that noise has
/// little effect on the acceleration.
constexpr std::size_t kApart = 4;

/// The play time jumps if the source is off by more periods than this.
constexpr double kJumpPeriods = 2;

/// A rough source: cycles of its mean, the most that one cycle counts, in limits, and the tracker's
/// frequency, 1/s.
constexpr double kMeanCycles = 64;
constexpr double kMostRough = 4;
constexpr double kTracker = 50;

double CheckedPeriod(double source_rate_hz) {
  RequireInRange("resampler: source rate (Hz)", source_rate_hz, 1, 1000);
  return 1 / source_rate_hz;
}

}  // namespace

Resampler::Resampler(double source_rate_hz, const Roughness& roughness)
    : period_s_(CheckedPeriod(source_rate_hz)),
      lag_s_(kLagPeriods * period_s_),
      roughness_(roughness) {}

void Resampler::Reset(const JointVector& x) noexcept {
  knots_[0] = {0, x};
  count_ = 1;
  stopped_ = true;
  mean_ = {};
  rough_ = false;
}

void Resampler::Begin(Time source_time, const JointVector& x) noexcept {
  first_ = source_time;
  knots_[0] = {0, x};
  count_ = 1;
  for (std::size_t i = 0; i < kPlayed; ++i) t_[i] = -lag_s_ - static_cast<double>(i) * kT;
  stopped_ = false;
  error_ = 0;
  drift_ = 0;
  rate_ = 0;
}

void Resampler::Deposit(Time source_time, const JointVector& x) noexcept {
  const double t = ToSeconds(source_time - first_);
  const double newest = knots_[count_ - 1].t;
  if (stopped_ || t < newest - kJumpPeriods * period_s_) {
    Begin(source_time, x);
    return;
  }
  if (t <= newest) {
    knots_[count_ - 1].x = x;
    return;
  }
  Append({t, x});
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
  const double e = newest - t_[0] - lag_s_;
  if (e > kJumpPeriods * period_s_) {
    for (double& t : t_) t += e;
    error_ = 0;
    return;
  }
  error_ += std::min(period_s_ / kFilter, 1.0) * (e - error_);
  drift_ = std::clamp(drift_ + kIntegral * error_ * period_s_, -kMostRate, kMostRate);
  rate_ = std::clamp(kProportional * error_ + drift_, -kMostRate, kMostRate);
}

void Resampler::Advance() noexcept {
  std::move_backward(t_.begin(), t_.end() - 1, t_.end());
  t_[0] = t_[1] + step_s();
  Track();
}

void Resampler::Track() noexcept {
  const std::array<JointVector, kPlayed> r{At(t_[0]), At(t_[1]), At(t_[2]), At(t_[3])};
  const bool of_positions = roughness_.order == 3;
  const double unit = of_positions ? kT * kT * kT : kT * kT;
  double roughest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double difference = of_positions ? r[0][i] - 3 * r[1][i] + 3 * r[2][i] - r[3][i]
                                           : r[0][i] - 2 * r[1][i] + r[2][i];
    const double share = std::abs(difference) / (unit * roughness_.limit[i]);
    mean_[i] += (std::min(share, kMostRough) - mean_[i]) / kMeanCycles;
    roughest = std::max(roughest, mean_[i]);
  }
  if (!rough_) {
    x_ = r[0];
    for (std::size_t i = 0; i < kJoints; ++i) v_[i] = (r[0][i] - r[1][i]) / kT;
  } else {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double ahead = r[0][i] - x_[i] - kT * v_[i];
      x_[i] += kT * v_[i] + 2 * kTracker * kT * ahead;
      v_[i] += kTracker * kTracker * kT * ahead;
    }
  }
  rough_ = roughest > (rough_ ? 0.5 : 1);
}

JointVector Resampler::Value(std::size_t cycles) const noexcept {
  if (!rough_) return At(t_[cycles]);
  JointVector x{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    x[i] = x_[i] - static_cast<double>(cycles) * kT * v_[i];
  }
  return x;
}

double Resampler::Slope(std::size_t knot, std::size_t axis) const noexcept {
  if (knot == 0) return Chord(0, 1, axis);
  if (knot + 1 == count_) return Beyond(axis).slope;
  const double before = knots_[knot].t - knots_[knot - 1].t;
  const double after = knots_[knot + 1].t - knots_[knot].t;
  return (after * Chord(knot - 1, knot, axis) + before * Chord(knot, knot + 1, axis)) /
         (before + after);
}

double Resampler::Chord(std::size_t from, std::size_t to, std::size_t axis) const noexcept {
  return (knots_[to].x[axis] - knots_[from].x[axis]) / (knots_[to].t - knots_[from].t);
}

Resampler::Parabola Resampler::Beyond(std::size_t axis) const noexcept {
  const std::size_t last = count_ - 1;
  if (count_ == 2) return {Chord(0, 1, axis), 0};
  const std::size_t apart = std::min(last / 2, kApart);
  const std::size_t middle = last - apart;
  const std::size_t first = middle - apart;
  const double late = Chord(middle, last, axis);
  const double early = Chord(first, middle, axis);
  const double bend = (late - early) / (knots_[last].t - knots_[first].t);
  return {late + bend * (knots_[last].t - knots_[middle].t), bend};
}

JointVector Resampler::At(double t) const noexcept {
  if (stopped_ || count_ == 1) return knots_[count_ - 1].x;
  const Knot& last = knots_[count_ - 1];
  JointVector x{};
  if (t >= last.t) {
    const double ahead = t - last.t;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const Parabola beyond = Beyond(j);
      x[j] = last.x[j] + ahead * (beyond.slope + ahead * beyond.bend);
    }
    return x;
  }
  if (t <= knots_[0].t) {
    for (std::size_t j = 0; j < kJoints; ++j) {
      x[j] = knots_[0].x[j] + (t - knots_[0].t) * Slope(0, j);
    }
    return x;
  }
  std::size_t i = count_ - 2;
  while (t < knots_[i].t) --i;
  const double h = knots_[i + 1].t - knots_[i].t;
  const double s = (t - knots_[i].t) / h;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double rise = knots_[i + 1].x[j] - knots_[i].x[j];
    const double a = h * Slope(i, j) - rise;
    const double b = rise - h * Slope(i + 1, j);
    x[j] = knots_[i].x[j] + s * rise + s * (1 - s) * ((1 - s) * a + s * b);
  }
  return x;
}

namespace {

/// Of the position's coordinates, and of a quaternion's components, which turn by half the angle.
/// The joints behind the robot's inverse kinematics bear less than the Cartesian limits: noise of
/// 1 um would break those of their jerk.
JointVector RoughnessOf(const CartesianLimits& limits) noexcept {
  constexpr double kShare = 0.15;
  const double p = kShare * limits.translation.dddp_max;
  const double r = kShare * limits.rotation.dddp_max / 2;
  return {p, p, p, r, r, r, r};
}

Transform PoseOf(const JointVector& x) noexcept {
  return model::Pose(Eigen::Quaterniond(x[3], x[4], x[5], x[6]).normalized(), {x[0], x[1], x[2]});
}

}  // namespace

JointVector PoseResampler::CoordinatesOf(const Transform& O_T_EE) const noexcept {
  const Eigen::Vector3d p = model::Position(O_T_EE);
  const Eigen::Quaterniond r = model::Orientation(O_T_EE);
  const double cosine = r.w() * last_[3] + r.x() * last_[4] + r.y() * last_[5] + r.z() * last_[6];
  const double sign = cosine < 0 ? -1 : 1;
  return {p.x(), p.y(), p.z(), sign * r.w(), sign * r.x(), sign * r.y(), sign * r.z()};
}

PoseResampler::PoseResampler(double source_rate_hz, const CartesianLimits& limits)
    : resampler_(source_rate_hz, {.limit = RoughnessOf(limits)}) {}

void PoseResampler::Reset(const Transform& O_T_EE) noexcept {
  last_ = CoordinatesOf(O_T_EE);
  resampler_.Reset(last_);
}

void PoseResampler::Deposit(Time source_time, const Transform& O_T_EE) noexcept {
  last_ = CoordinatesOf(O_T_EE);
  resampler_.Deposit(source_time, last_);
}

Transform PoseResampler::Value(std::size_t cycles) const noexcept {
  return PoseOf(resampler_.Value(cycles));
}

Transform PoseResampler::Source() const noexcept {
  return PoseOf(resampler_.Source());
}

}  // namespace twin::reference
