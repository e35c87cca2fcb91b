#include "planning/path_timing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "planning/joint_space.h"
#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::planning {
namespace {

using reference::Timing;
using reference::Trajectory;
using reference::Waypoint;

// Peaks of the rest-to-rest quintic 10 x^3 - 15 x^4 + 6 x^5.
constexpr double kPeakVelocity = 15.0 / 8;
const double kPeakAcceleration = 10 / std::sqrt(3.0);
constexpr double kPeakJerk = 60;

/// Keeps below the shares by more than the rounding of times to nanoseconds.
constexpr double kSlower = 1 + 1e-6;

constexpr int kFittingRounds = 10;
constexpr int kSamplesPerWay = 12;
constexpr double kLeastWay = 0.01;  ///< s; shortest time of a segment

/// Share that a motion uses: 1 is the limit. Stretching its times by this factor gives 1.
/// @param dq_limit  of the velocity, where it is reached.
double Load(double dq, double dq_limit, double ddq, double dddq, std::size_t joint,
            const Timing& pace, const JointLimits& limits) {
  return std::max({dq / (pace.velocity_scale * dq_limit),
                   std::sqrt(ddq / (pace.acceleration_scale * limits.ddq_max[joint])),
                   std::cbrt(dddq / (pace.jerk_scale * limits.dddq_max[joint]))});
}

/// Time of a segment from rest to rest, s.
double RestToRestTime(const JointVector& a, const JointVector& b, const Timing& pace,
                      const JointLimits& limits) {
  double longest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double L = std::abs(b[i] - a[i]);
    longest = std::max(longest, Load(kPeakVelocity * L, limits.dq_max[i], kPeakAcceleration * L,
                                     kPeakJerk * L, i, pace, limits));
  }
  const bool is_box = limits.deceleration == JointVector{};
  if (is_box || longest <= kLeastWay) return longest;
  return ToSeconds(Trajectory({{.q = a}, {.q = b}}, pace, limits).duration());
}

/// The same for a trajectory's peaks, which are shares of the limits.
double Load(const reference::PeakShares& peaks, const Timing& pace) {
  double load = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    load = std::max({load, peaks.velocity[i] / pace.velocity_scale,
                     std::sqrt(peaks.acceleration[i] / pace.acceleration_scale),
                     std::cbrt(peaks.jerk[i] / pace.jerk_scale)});
  }
  return load;
}

/// The points, at the given times after each previous one.
std::vector<Waypoint> Timed(std::vector<Waypoint> points, const std::vector<double>& ways_s,
                            double stretch) {
  double time_s = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) time_s += ways_s[i - 1] * stretch;
    points[i].at = FromSeconds(time_s);
  }
  return points;
}

/// @returns nullopt if the spline through the points leaves the position limits.
std::optional<Trajectory> Laid(const std::vector<Waypoint>& waypoints, const JointLimits& limits) {
  try {
    return Trajectory(waypoints, {}, limits);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Scales all times by one factor, so that the most loaded point uses up its share.
std::optional<TimedPath> AtFullPace(const std::vector<Waypoint>& points,
                                    const std::vector<double>& ways_s, const Timing& pace,
                                    const JointLimits& limits) {
  // Slow enough for every limit, for any shares of the segments.
  const double slow = 20 / *std::min_element(ways_s.begin(), ways_s.end());
  const auto slowly = Laid(Timed(points, ways_s, slow), limits);
  if (!slowly) return std::nullopt;
  const double stretch = slow * Load(slowly->peaks(), pace) * kSlower;
  std::vector<Waypoint> waypoints = Timed(points, ways_s, stretch);
  auto trajectory = Laid(waypoints, limits);
  if (!trajectory) return std::nullopt;
  return TimedPath{std::move(*trajectory), std::move(waypoints)};
}

/// The load of each segment, by sampling.
std::vector<double> LoadsOf(const TimedPath& path, const Timing& pace, const JointLimits& limits) {
  std::vector<double> loads;
  for (std::size_t way = 0; way + 1 < path.waypoints.size(); ++way) {
    const Duration begin = *path.waypoints[way].at;
    const Duration step = (*path.waypoints[way + 1].at - begin) / kSamplesPerWay;
    double load = 0;
    auto before = path.trajectory.Sample(begin);
    for (int k = 1; k <= kSamplesPerWay; ++k) {
      const auto target = path.trajectory.Sample(begin + k * step);
      for (std::size_t i = 0; i < kJoints; ++i) {
        const double dddq = std::abs(target.ddq[i] - before.ddq[i]) / ToSeconds(step);
        const double dq_limit = limits.VelocityLimit(i, target.q[i], target.dq[i]);
        load = std::max(load, Load(std::abs(target.dq[i]), dq_limit, std::abs(target.ddq[i]), dddq,
                                   i, pace, limits));
      }
      before = target;
    }
    loads.push_back(load);
  }
  return loads;
}

/// The segments on which the trajectory comes closer than half the clearance to a part.
std::set<std::size_t> WaysThatHit(const TimedPath& path, MotionChecker& checker) {
  std::set<std::size_t> hits;
  std::size_t way = 0;
  JointVector last = path.trajectory.start();
  double travelled = 0;
  const Duration end = path.trajectory.duration();
  for (Duration t{}; t < end; t += kCycle) {
    const JointVector q = path.trajectory.Sample(t).q;
    const JointVector next = path.trajectory.Sample(t + kCycle).q;
    travelled += checker.Travel(last, q);
    last = q;
    while (t >= *path.waypoints[way + 1].at) ++way;
    if (travelled + checker.Travel(q, next) <= checker.clearance()) continue;
    travelled = 0;
    if (!checker.IsFreeBy(checker.clearance() / 2, q)) hits.insert(way);
  }
  return hits;
}

/// Splits each of these segments at its middle. @param stop  instead, stop at both its ends; a
/// segment between two stops is straight.
void Split(std::vector<Waypoint>& points, const std::set<std::size_t>& ways, bool stop) {
  std::vector<Waypoint> finer;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == points.size();
    const bool hits = ways.contains(i) || (i > 0 && ways.contains(i - 1));
    finer.push_back(points[i]);
    finer.back().stop = points[i].stop || (stop && hits && !is_end);
    if (ways.contains(i) && !stop) {
      finer.push_back({.q = Between(points[i].q, points[i + 1].q, 0.5)});
    }
  }
  points = std::move(finer);
}

std::set<std::size_t> AllWays(const std::vector<Waypoint>& points) {
  std::set<std::size_t> all;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) all.insert(i);
  return all;
}

bool IsFaster(const std::optional<TimedPath>& a, const std::optional<TimedPath>& b) {
  return a && (!b || a->trajectory.duration() < b->trajectory.duration());
}

std::vector<Waypoint> PointsOf(const std::vector<JointVector>& path, bool stops) {
  std::vector<Waypoint> points;
  points.reserve(path.size());
  for (const JointVector& q : path) points.push_back({.q = q, .stop = stops});
  points.front().stop = points.back().stop = false;  // at rest in any case
  return points;
}

}  // namespace

TimedPath StopAndGo(const std::vector<JointVector>& path, const Timing& pace,
                    const JointLimits& limits) {
  std::vector<double> ways_s;
  for (std::size_t i = 1; i < path.size(); ++i) {
    ways_s.push_back(std::max(kLeastWay, RestToRestTime(path[i - 1], path[i], pace, limits)));
  }
  std::vector<Waypoint> waypoints = Timed(PointsOf(path, true), ways_s, kSlower);
  Trajectory trajectory(waypoints, {}, limits);
  return {std::move(trajectory), std::move(waypoints)};
}

std::optional<TimedPath> RunThrough(const std::vector<Waypoint>& points, const Timing& pace,
                                    const JointLimits& limits) {
  std::vector<double> ways_s;
  for (std::size_t i = 1; i < points.size(); ++i) {
    double time_s = kLeastWay;
    for (std::size_t j = 0; j < kJoints; ++j) {
      time_s = std::max(time_s, std::abs(points[i].q[j] - points[i - 1].q[j]) / limits.dq_max[j]);
    }
    ways_s.push_back(time_s);
  }
  std::optional<TimedPath> best;
  for (int round = 0; round < kFittingRounds; ++round) {
    std::optional<TimedPath> timed = AtFullPace(points, ways_s, pace, limits);
    if (!timed) break;
    const std::vector<double> loads = LoadsOf(*timed, pace, limits);
    for (std::size_t i = 0; i < ways_s.size(); ++i) {
      ways_s[i] = std::max(kLeastWay, ways_s[i] * std::sqrt(std::min(1.0, loads[i])));
    }
    if (IsFaster(timed, best)) best = std::move(timed);
  }
  return best;
}

TimedPath TimePath(const std::vector<JointVector>& path, const Timing& pace,
                   const JointLimits& limits, MotionChecker& checker) {
  constexpr int kSplits = 4;
  constexpr int kRounds = 8;
  TimedPath safe = StopAndGo(path, pace, limits);
  if (path.size() == 2) return safe;
  // A point in the middle of each segment keeps the spline close to it and mostly makes it faster.
  std::vector<Waypoint> points = PointsOf(path, false);
  std::vector<Waypoint> halved = points;
  Split(halved, AllWays(halved), false);
  auto timed = RunThrough(points, pace, limits);
  if (auto other = RunThrough(halved, pace, limits); IsFaster(other, timed)) {
    points = std::move(halved);
    timed = std::move(other);
  }
  for (int round = 0; round < kRounds; ++round) {
    const std::set<std::size_t> hits = timed ? WaysThatHit(*timed, checker) : AllWays(points);
    if (checker.IsExhausted()) break;
    if (hits.empty()) {
      const bool faster = timed->trajectory.duration() < safe.trajectory.duration();
      return faster ? std::move(*timed) : std::move(safe);
    }
    Split(points, hits, round >= kSplits);
    timed = RunThrough(points, pace, limits);
  }
  return safe;
}

}  // namespace twin::planning
