#include "twin/reference/trajectory.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "reference/quintic_path.h"
#include "twin/core/error.h"

namespace twin::reference {
namespace {

using internal::Extreme;
using internal::PathExtremes;

constexpr Duration kLongest = std::chrono::hours(24);

/// Least distance of neighbours on an untimed path, in some joint, rad.
constexpr double kLeastDistance = 1e-6;

/// Shorter segments count as densely sampled data in the proposed cure.
constexpr double kDenseSpacingSeconds = 0.0101;

template <class... Args>
[[noreturn]] void Refuse(fmt::format_string<Args...> text, Args&&... args) {
  throw InputError("trajectory: " + fmt::format(text, std::forward<Args>(args)...));
}

std::string PointName(const std::vector<Waypoint>& waypoints, std::size_t i) {
  const std::string& where = waypoints[i].where;
  return where.empty() ? fmt::format("point {}", i + 1)
                       : fmt::format("point {} ({})", i + 1, where);
}

/// Location of an extreme, for messages.
std::string PlaceOf(const Extreme& extreme, const std::vector<Waypoint>& waypoints) {
  return fmt::format("at {:.4f} s, between {} and {}", extreme.at_s,
                     PointName(waypoints, extreme.segment),
                     PointName(waypoints, extreme.segment + 1));
}

bool IsInside(double q, const JointLimits& limits, std::size_t joint) {
  return q >= limits.q_min[joint] + kPositionMargin && q <= limits.q_max[joint] - kPositionMargin;
}

void CheckPositions(const std::vector<Waypoint>& waypoints, const JointLimits& limits) {
  if (waypoints.size() < 2) {
    Refuse("{} point{}; at least two are needed", waypoints.size(),
           waypoints.size() == 1 ? "" : "s");
  }
  if (waypoints.size() > kMaxWaypoints) {
    Refuse("{} points; at most {} are possible: give fewer, a spline goes through them",
           waypoints.size(), kMaxWaypoints);
  }
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      const double q = waypoints[i].q[joint];
      if (!std::isfinite(q)) {
        Refuse("{}: joint {} is {}; it must be a finite number of rad", PointName(waypoints, i),
               joint + 1, q);
      }
      if (!IsInside(q, limits, joint)) {
        Refuse("{}: joint {} is {} rad, not inside its limits ({}, {}) rad; move the point inside",
               PointName(waypoints, i), joint + 1, q, limits.q_min[joint], limits.q_max[joint]);
      }
    }
  }
}

/// Whether the points have times.
bool IsTimed(const std::vector<Waypoint>& waypoints) {
  const bool timed = waypoints.front().at.has_value();
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (waypoints[i].at.has_value() == timed) continue;
    Refuse("{} has {} time but {} has {}; give `at` to all points or to none",
           PointName(waypoints, i), timed ? "no" : "a", PointName(waypoints, 0),
           timed ? "one" : "none");
  }
  return timed;
}

void CheckDuration(Duration duration) {
  if (duration > Duration::zero() && duration <= kLongest) return;
  Refuse("the duration is {} s; it must be above 0 and at most {} s", ToSeconds(duration),
         ToSeconds(kLongest));
}

/// Times given with the points.
std::vector<Duration> GivenTimes(const std::vector<Waypoint>& waypoints, const Timing& timing) {
  if (*waypoints.front().at != Duration::zero()) {
    Refuse("{}: its time is {} s; the first point's must be 0 s", PointName(waypoints, 0),
           ToSeconds(*waypoints.front().at));
  }
  std::vector<Duration> knots{Duration::zero()};
  knots.reserve(waypoints.size());
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (*waypoints[i].at <= knots.back()) {
      Refuse("{}: its time {} s is not after the {} s of {}; times must rise",
             PointName(waypoints, i), ToSeconds(*waypoints[i].at), ToSeconds(knots.back()),
             PointName(waypoints, i - 1));
    }
    knots.push_back(*waypoints[i].at);
  }
  CheckDuration(knots.back());
  if (timing.duration && *timing.duration != knots.back()) {
    Refuse(
        "the duration is {} s but the last point's time is {} s; leave one out or make them "
        "equal",
        ToSeconds(*timing.duration), ToSeconds(knots.back()));
  }
  return knots;
}

/// Times in s of untimed points before stretching: each distance takes the time of its slowest
/// joint at its velocity limit.
std::vector<double> DistanceTimes(const std::vector<Waypoint>& waypoints,
                                  const JointLimits& limits) {
  std::vector<double> times_s{0.0};
  times_s.reserve(waypoints.size());
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    double furthest = 0;
    double needed_s = 0;
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      const double distance = std::abs(waypoints[i].q[joint] - waypoints[i - 1].q[joint]);
      furthest = std::max(furthest, distance);
      needed_s = std::max(needed_s, distance / limits.dq_max[joint]);
    }
    if (furthest < kLeastDistance) {
      Refuse("{} and {} coincide (no joint moves by {} rad); remove one, or give all points times",
             PointName(waypoints, i - 1), PointName(waypoints, i), kLeastDistance);
    }
    times_s.push_back(times_s.back() + needed_s);
  }
  return times_s;
}

std::vector<Duration> Stretched(const std::vector<Waypoint>& waypoints,
                                const std::vector<double>& times_s, double factor) {
  if (!(times_s.back() * factor <= ToSeconds(kLongest))) {
    Refuse("takes {:.6g} s at the wanted pace; at most {} s are possible", times_s.back() * factor,
           ToSeconds(kLongest));
  }
  std::vector<Duration> knots;
  knots.reserve(times_s.size());
  for (const double time_s : times_s) {
    knots.push_back(FromSeconds(time_s * factor));
    if (knots.size() == 1 || knots.back() > knots[knots.size() - 2]) continue;
    Refuse("{} s are too short to tell {} and {} apart", times_s.back() * factor,
           PointName(waypoints, knots.size() - 2), PointName(waypoints, knots.size() - 1));
  }
  return knots;
}

JointVector Shares(const std::array<Extreme, kJoints>& peaks, const JointVector& limit) {
  JointVector shares;
  for (std::size_t j = 0; j < kJoints; ++j) shares[j] = std::abs(peaks[j].value) / limit[j];
  return shares;
}

PeakShares SharesOf(const PathExtremes& extremes, const JointLimits& limits) {
  return {Shares(extremes.dq, limits.dq_max), Shares(extremes.ddq, limits.ddq_max),
          Shares(extremes.dddq, limits.dddq_max)};
}

/// @param x  since the begin of the segment, s.
JointTarget At(const QuinticSegment& segment, double x) noexcept {
  JointTarget target;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto& c = segment.c[j];
    target.q[j] = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
    target.dq[j] = c[1] + x * (2 * c[2] + x * (3 * c[3] + x * (4 * c[4] + x * 5 * c[5])));
    target.ddq[j] = 2 * c[2] + x * (6 * c[3] + x * (12 * c[4] + x * 20 * c[5]));
  }
  return target;
}

/// Where the velocity limit depends on the position: the peaks' shares of it, by sampling, with
/// room for what lies between the samples.
void KeepSharesByPosition(const std::vector<QuinticSegment>& segments, const JointLimits& limits,
                          JointVector& shares) {
  constexpr double kBetween = 1.001;
  constexpr std::size_t kSamples = 65536;
  if (limits.deceleration == JointVector{}) return;
  const std::size_t each = std::clamp<std::size_t>(kSamples / segments.size(), 16, 512);
  for (const QuinticSegment& segment : segments) {
    for (std::size_t k = 1; k <= each; ++k) {
      const double x = segment.length_s * static_cast<double>(k) / static_cast<double>(each);
      const JointTarget target = At(segment, x);
      for (std::size_t j = 0; j < kJoints; ++j) {
        const double limit = limits.VelocityLimit(j, target.q[j], target.dq[j]);
        shares[j] = std::max(shares[j], kBetween * std::abs(target.dq[j]) / limit);
        if (std::isfinite(shares[j])) continue;
        Refuse(
            "joint {} moves at {:.4f} rad, where the robot permits no velocity towards the end of "
            "its range; stay {:.4f} rad from its limits ({}, {}) rad",
            j + 1, target.q[j], limits.StillZone(j), limits.q_min[j], limits.q_max[j]);
      }
    }
  }
}

double Largest(const JointVector& values) {
  return *std::max_element(values.begin(), values.end());
}

/// Factor on all times that brings the peaks to these shares: velocity scales with its inverse,
/// acceleration with its inverse square, jerk with its inverse cube.
double StretchTo(const PeakShares& peaks, double velocity, double acceleration, double jerk) {
  return std::max({Largest(peaks.velocity) / velocity,
                   std::sqrt(Largest(peaks.acceleration) / acceleration),
                   std::cbrt(Largest(peaks.jerk) / jerk)});
}

void CheckShare(const char* name, double share) {
  if (share > 0 && share <= 1) return;
  Refuse("the {} share of the limits is {}; it must lie in (0, 1]", name, share);
}

/// Untimed points at the fastest uniform pace within the shares.
std::vector<Duration> PacedTimes(const std::vector<Waypoint>& waypoints,
                                 const std::vector<double>& times_s, const Timing& timing,
                                 const JointLimits& limits) {
  CheckShare("velocity", timing.velocity_scale);
  CheckShare("acceleration", timing.acceleration_scale);
  CheckShare("jerk", timing.jerk_scale);
  // The first round gives the factor in closed form; the others compensate the rounding of times to
  // nanoseconds, which matters only for very close points.
  constexpr int kRounds = 5;
  double factor = 1;
  std::vector<Duration> knots = Stretched(waypoints, times_s, factor);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<QuinticSegment> segments = internal::FitSpline(waypoints, knots);
    PeakShares peaks = SharesOf(internal::FindExtremes(segments), limits);
    KeepSharesByPosition(segments, limits, peaks.velocity);
    const double needed =
        StretchTo(peaks, timing.velocity_scale, timing.acceleration_scale, timing.jerk_scale) /
        kAdmissibleShare;
    if (round > 0 && needed * kAdmissibleShare <= 1) break;
    factor *= needed;
    knots = Stretched(waypoints, times_s, factor);
  }
  return knots;
}

std::vector<Duration> KnotTimes(const std::vector<Waypoint>& waypoints, const Timing& timing,
                                const JointLimits& limits) {
  if (IsTimed(waypoints)) return GivenTimes(waypoints, timing);
  const std::vector<double> times_s = DistanceTimes(waypoints, limits);
  if (!timing.duration) return PacedTimes(waypoints, times_s, timing, limits);
  CheckDuration(*timing.duration);
  auto knots = Stretched(waypoints, times_s, ToSeconds(*timing.duration) / times_s.back());
  knots.back() = *timing.duration;
  return knots;
}

void CheckRange(const PathExtremes& extremes, const std::vector<Waypoint>& waypoints,
                const JointLimits& limits) {
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    for (const Extreme& extreme : {extremes.q_lowest[joint], extremes.q_highest[joint]}) {
      if (IsInside(extreme.value, limits, joint)) continue;
      Refuse(
          "joint {} swings to {:.7g} rad {}, not inside its limits ({}, {}) rad; move these "
          "points further from the limit, or put another between them",
          joint + 1, extreme.value, PlaceOf(extreme, waypoints), limits.q_min[joint],
          limits.q_max[joint]);
    }
  }
}

/// A limited derivative of the path.
struct Rate {
  const char* name;
  const char* unit;
  const std::array<Extreme, kJoints>& peaks;
  const JointVector& limits;
};

[[noreturn]] void RefuseRate(const Rate& rate, double stretch,
                             const std::vector<QuinticSegment>& segments,
                             const std::vector<Waypoint>& waypoints) {
  const JointVector shares = Shares(rate.peaks, rate.limits);
  const auto joint =
      static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
  const Extreme& peak = rate.peaks[joint];
  const double duration_s = ToSeconds(segments.back().begin) + segments.back().length_s;
  std::string cure = fmt::format(
      "the same path is admissible from {:.3f} s in all (now {:.9g} s): stretch all times by "
      "{:.6f}",
      std::ceil(duration_s * stretch * 1e3) / 1e3, duration_s, std::ceil(stretch * 1e6) / 1e6);
  if (segments[peak.segment].length_s < kDenseSpacingSeconds) {
    cure += fmt::format(
        ", or, as these points are only {:.3g} ms apart, give them with more digits, smooth them "
        "or use fewer",
        segments[peak.segment].length_s * 1e3);
  }
  Refuse(
      "joint {} reaches {:.7g} {} {}; its {} limit is {} {}, of which 1e-6 is kept for "
      "rounding; {}",
      joint + 1, peak.value, rate.unit, PlaceOf(peak, waypoints), rate.name, rate.limits[joint],
      rate.unit, cure);
}

void CheckRates(const PathExtremes& extremes, const PeakShares& shares,
                const std::vector<QuinticSegment>& segments, const std::vector<Waypoint>& waypoints,
                const JointLimits& limits) {
  const double stretch = StretchTo(shares, kAdmissibleShare, kAdmissibleShare, kAdmissibleShare);
  if (stretch <= 1) return;
  // Names the one that needs the largest stretch.
  const double velocity = Largest(shares.velocity);
  const double acceleration = std::sqrt(Largest(shares.acceleration));
  const double jerk = std::cbrt(Largest(shares.jerk));
  if (velocity >= std::max(acceleration, jerk)) {
    RefuseRate({"velocity", "rad/s", extremes.dq, limits.dq_max}, stretch, segments, waypoints);
  }
  if (acceleration >= jerk) {
    RefuseRate({"acceleration", "rad/s^2", extremes.ddq, limits.ddq_max}, stretch, segments,
               waypoints);
  }
  RefuseRate({"jerk", "rad/s^3", extremes.dddq, limits.dddq_max}, stretch, segments, waypoints);
}

}  // namespace

Trajectory::Trajectory(const std::vector<Waypoint>& waypoints, const Timing& timing,
                       const JointLimits& limits) {
  CheckPositions(waypoints, limits);
  const std::vector<Duration> knots = KnotTimes(waypoints, timing, limits);
  segments_ = internal::FitSpline(waypoints, knots);
  const PathExtremes extremes = internal::FindExtremes(segments_);
  peaks_ = SharesOf(extremes, limits);
  CheckRange(extremes, waypoints, limits);
  CheckRates(extremes, peaks_, segments_, waypoints, limits);
  KeepSharesByPosition(segments_, limits, peaks_.velocity);
  duration_ = knots.back();
  start_ = waypoints.front().q;
  goal_ = waypoints.back().q;
}

JointTarget Trajectory::Sample(Duration t) const noexcept {
  if (t <= Duration::zero()) return {start_, {}, {}};
  if (t >= duration_) return {goal_, {}, {}};
  const auto next =
      std::upper_bound(segments_.begin(), segments_.end(), t,
                       [](Duration at, const QuinticSegment& s) { return at < s.begin; });
  const QuinticSegment& segment = *std::prev(next);
  return At(segment, ToSeconds(t - segment.begin));
}

}  // namespace twin::reference
