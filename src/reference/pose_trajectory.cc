#include "twin/reference/pose_trajectory.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

constexpr Duration kLongestPoses = std::chrono::hours(24);

/// Peaks of the minimum-jerk profile of length 1 and duration 1.
constexpr double kPeakVelocity = 1.875;
const double kPeakAcceleration = 10 / std::numbers::sqrt3;
constexpr double kPeakJerk = 60;

/// Least distance of neighbours on an untimed path, m or rad.
constexpr double kLeastPoseDistance = 1e-6;
/// A rotation this near to half a turn has no shortest direction, rad.
constexpr double kAmbiguous = 1e-3;

template <class... Args>
[[noreturn]] void RefusePoses(fmt::format_string<Args...> text, Args&&... args) {
  throw InputError("poses: " + fmt::format(text, std::forward<Args>(args)...));
}

std::string PoseName(const std::vector<PoseWaypoint>& waypoints, std::size_t i) {
  const std::string& where = waypoints[i].where;
  return where.empty() ? fmt::format("pose {}", i + 1) : fmt::format("pose {} ({})", i + 1, where);
}

bool IsPose(const Transform& T) {
  constexpr double kTolerance = 1e-5;
  if (!std::ranges::all_of(T, [](double x) { return std::isfinite(x); })) return false;
  if (T[3] != 0 || T[7] != 0 || T[11] != 0 || T[15] != 1) return false;
  const Eigen::Map<const Eigen::Matrix4d> X(T.data());
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kTolerance &&
         R.determinant() > 0;
}

std::vector<Vector6> Ways(const std::vector<PoseWaypoint>& waypoints) {
  if (waypoints.size() < 2 || waypoints.size() > kMaxWaypoints) {
    RefusePoses("{} given; at least two are needed, at most {} possible", waypoints.size(),
                kMaxWaypoints);
  }
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (IsPose(waypoints[i].O_T_EE)) continue;
    RefusePoses("{} is no pose: its numbers must be finite, its rotation orthonormal within 1e-5",
                PoseName(waypoints, i));
  }
  std::vector<Vector6> ways;
  ways.reserve(waypoints.size() - 1);
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    ways.push_back(model::WayTo(waypoints[i - 1].O_T_EE, waypoints[i].O_T_EE));
    if (HalfNorm(ways.back(), 3) <= std::numbers::pi - kAmbiguous) continue;
    RefusePoses(
        "from {} to {} it turns by {:.4f} rad, half a revolution: either way is as short; give a "
        "pose between them",
        PoseName(waypoints, i - 1), PoseName(waypoints, i), HalfNorm(ways.back(), 3));
  }
  return ways;
}

/// @returns the shortest time for a distance within the shares of its limits, s.
double ShortestTime(double distance, const CartesianBound& bound, const Timing& shares) {
  return std::max(
      {kPeakVelocity * distance / (shares.velocity_scale * bound.dp_max),
       std::sqrt(kPeakAcceleration * distance / (shares.acceleration_scale * bound.ddp_max)),
       std::cbrt(kPeakJerk * distance / (shares.jerk_scale * bound.dddp_max))});
}

double ShortestTime(const Vector6& way, const CartesianLimits& limits, const Timing& shares) {
  return std::max(ShortestTime(HalfNorm(way, 0), limits.translation, shares),
                  ShortestTime(HalfNorm(way, 3), limits.rotation, shares));
}

void CheckTiming(const Timing& timing) {
  for (const auto& [name, share] : {std::pair("velocity", timing.velocity_scale),
                                    std::pair("acceleration", timing.acceleration_scale),
                                    std::pair("jerk", timing.jerk_scale)}) {
    if (share > 0 && share <= 1) continue;
    RefusePoses("the {} share of the limits is {}; it must lie in (0, 1]", name, share);
  }
  if (timing.duration &&
      (*timing.duration <= Duration::zero() || *timing.duration > kLongestPoses)) {
    RefusePoses("the duration is {} s; it must be above 0 and at most {} s",
                ToSeconds(*timing.duration), ToSeconds(kLongestPoses));
  }
}

std::vector<Duration> GivenTimes(const std::vector<PoseWaypoint>& waypoints, const Timing& timing) {
  std::vector<Duration> knots;
  knots.reserve(waypoints.size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const auto& at = waypoints[i].at;
    if (!at)
      RefusePoses("{} has no time but pose 1 has one; give `at` to all or to none",
                  PoseName(waypoints, i));
    if (i == 0 && *at != Duration::zero()) {
      RefusePoses("{}: its time is {} s; the first one's must be 0 s", PoseName(waypoints, 0),
                  ToSeconds(*at));
    }
    if (i > 0 && *at <= knots.back()) {
      RefusePoses("{}: its time {} s is not after the {} s of the one before; times must rise",
                  PoseName(waypoints, i), ToSeconds(*at), ToSeconds(knots.back()));
    }
    knots.push_back(*at);
  }
  if (timing.duration && *timing.duration != knots.back()) {
    RefusePoses(
        "the duration is {} s but the last pose's time is {} s; leave one out or make them equal",
        ToSeconds(*timing.duration), ToSeconds(knots.back()));
  }
  return knots;
}

std::vector<Duration> PacedTimes(const std::vector<PoseWaypoint>& waypoints,
                                 const std::vector<Vector6>& ways, const Timing& timing,
                                 const CartesianLimits& limits) {
  std::vector<double> times_s{0};
  times_s.reserve(waypoints.size());
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (waypoints[i + 1].at) {
      RefusePoses("{} has a time but pose 1 has none; give `at` to all or to none",
                  PoseName(waypoints, i + 1));
    }
    if (std::max(HalfNorm(ways[i], 0), HalfNorm(ways[i], 3)) < kLeastPoseDistance) {
      RefusePoses("{} and {} coincide; remove one, or give all poses times", PoseName(waypoints, i),
                  PoseName(waypoints, i + 1));
    }
    times_s.push_back(times_s.back() + ShortestTime(ways[i], limits, timing));
  }
  const double factor = timing.duration ? ToSeconds(*timing.duration) / times_s.back() : 1;
  if (!(times_s.back() * factor <= ToSeconds(kLongestPoses))) {
    RefusePoses("take {:.6g} s at the wanted pace; at most {} s are possible",
                times_s.back() * factor, ToSeconds(kLongestPoses));
  }
  std::vector<Duration> knots;
  knots.reserve(times_s.size());
  // Round up, so that rounding never makes a segment too fast.
  for (const double t : times_s)
    knots.push_back(Duration(std::llround(std::ceil(t * factor * 1e9))));
  if (timing.duration) knots.back() = *timing.duration;
  return knots;
}

void CheckLimit(std::string_view what, std::string_view unit, double value, double limit,
                const std::string& place, double shortest_s) {
  if (value <= kAdmissibleShare * limit) return;
  RefusePoses(
      "{}: the {} of the end effector reaches {:.6g} {}, its limit is {:.6g}; give this piece at "
      "least {:.4f} s",
      place, what, value, unit, limit, shortest_s);
}

void CheckLimits(const std::vector<PoseWaypoint>& waypoints, std::size_t i, const Vector6& way,
                 double length_s, const CartesianLimits& limits) {
  const Timing full{.duration = {}, .velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1};
  const double shortest_s = ShortestTime(way, limits, full) * (1 + 1e-4);
  const std::string place =
      fmt::format("from {} to {}", PoseName(waypoints, i), PoseName(waypoints, i + 1));
  const auto check = [&](double distance, const CartesianBound& bound, bool turns) {
    const double rate = 1 / length_s;
    CheckLimit(turns ? "angular velocity" : "velocity", turns ? "rad/s" : "m/s",
               kPeakVelocity * distance * rate, bound.dp_max, place, shortest_s);
    CheckLimit(turns ? "angular acceleration" : "acceleration", turns ? "rad/s^2" : "m/s^2",
               kPeakAcceleration * distance * rate * rate, bound.ddp_max, place, shortest_s);
    CheckLimit(turns ? "angular jerk" : "jerk", turns ? "rad/s^3" : "m/s^3",
               kPeakJerk * distance * rate * rate * rate, bound.dddp_max, place, shortest_s);
  };
  check(HalfNorm(way, 0), limits.translation, false);
  check(HalfNorm(way, 3), limits.rotation, true);
}

Eigen::Vector3d AsEigen(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

PoseTrajectory::PoseTrajectory(const std::vector<PoseWaypoint>& waypoints, const Timing& timing,
                               const CartesianLimits& limits) {
  CheckTiming(timing);
  const std::vector<Vector6> ways = Ways(waypoints);
  const std::vector<Duration> knots = waypoints.front().at
                                          ? GivenTimes(waypoints, timing)
                                          : PacedTimes(waypoints, ways, timing, limits);
  if (knots.back() > kLongestPoses) {
    RefusePoses("the last pose's time is {} s; at most {} s are possible", ToSeconds(knots.back()),
                ToSeconds(kLongestPoses));
  }
  segments_.reserve(ways.size());
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Vector6& way = ways[i];
    const double length_s = ToSeconds(knots[i + 1] - knots[i]);
    CheckLimits(waypoints, i, way, length_s, limits);
    segments_.push_back({.begin = knots[i],
                         .length_s = length_s,
                         .from = waypoints[i].O_T_EE,
                         .way = {way[0], way[1], way[2]},
                         .phi = {way[3], way[4], way[5]}});
  }
  duration_ = knots.back();
  goal_ = waypoints.back().O_T_EE;
}

PoseTarget PoseTrajectory::Sample(Duration t) const noexcept {
  if (t <= Duration::zero()) return {start(), {}};
  if (t >= duration_) return {goal_, {}};
  const auto after = std::ranges::upper_bound(segments_, t, {}, &Segment::begin);
  const Segment& segment = *std::prev(after);
  const double x = ToSeconds(t - segment.begin) / segment.length_s;
  const double s = x * x * x * (10 + x * (-15 + 6 * x));
  const double ds = 30 * x * x * (1 - x) * (1 - x) / segment.length_s;
  const Eigen::Vector3d way = AsEigen(segment.way);
  const Eigen::Vector3d phi = AsEigen(segment.phi);
  PoseTarget target;
  target.O_T_EE = model::Turned(segment.from, s * phi, model::Position(segment.from) + s * way);
  target.O_dP_EE = {ds * way[0], ds * way[1], ds * way[2], ds * phi[0], ds * phi[1], ds * phi[2]};
  return target;
}

}  // namespace twin::reference
