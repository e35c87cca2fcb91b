#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// One point the arm passes through.
struct Waypoint {
  JointVector q{};  ///< rad
  std::optional<Duration>
      at;  ///< time from the start; given for all points (strictly rising, the first 0) or for none
  bool stop = false;  ///< come to rest here
  std::string where;  ///< where it was read ("canonical.yaml:14"), for messages; may be empty
};

/// How fast an untimed trajectory runs.
struct Timing {
  std::optional<Duration> duration;  ///< total time; the points are spaced by their distance
  double velocity_scale =
      0.5;  ///< without a duration: the fastest uniform pace at which peak velocity,
  double acceleration_scale = 0.2;  ///< acceleration
  double jerk_scale = 0.1;  ///< and jerk stay within these shares of the limits, each in (0, 1]
};

/// Largest magnitude of a quantity over a trajectory, per joint, as a share of its limit.
struct PeakShares {
  JointVector velocity{};
  JointVector acceleration{};
  JointVector jerk{};
};

/// A joint-space path through waypoints: a quintic spline, at rest (dq = ddq = 0) at both ends and
/// at every stop, with continuous derivatives up to the fourth in between.
///
/// Its jerk is bounded, so the backward differences at 1 ms that INT forms, averages of the
/// derivatives over one, two and three periods, never exceed the derivatives' own peaks. The peaks
/// are found at the roots of the next derivative, not by sampling.
///
/// Threads: immutable after construction, any thread. Real-time: Sample() is noexcept, O(log
/// points), allocates nothing.
class Trajectory {
 public:
  /// @throws InputError when: fewer than two points; a value is not finite; a point or the path
  /// between points is outside the position limits; times do not rise; the path breaks a velocity,
  /// acceleration or jerk limit. The text names the point or time, joint, value, limit and the cure
  /// (e.g. the shortest admissible duration).
  Trajectory(const std::vector<Waypoint>& waypoints, const Timing& timing,
             const JointLimits& limits);

  /// Total time.
  [[nodiscard]] Duration duration() const noexcept { return duration_; }

  /// @param t  time since the start; before 0 the first point at rest, after duration() the last
  /// point at rest.
  [[nodiscard]] JointTarget Sample(Duration t) const noexcept;

  /// Peaks as shares of the limits given at construction.
  [[nodiscard]] const PeakShares& peaks() const noexcept { return peaks_; }

  [[nodiscard]] const JointVector& start() const noexcept { return start_; }
  [[nodiscard]] const JointVector& goal() const noexcept { return goal_; }

 private:
  /// One quintic per joint on [begin_s, begin_s + length_s]: sum of c[joint][i] (t - begin_s)^i.
  struct Segment {
    double begin_s = 0;
    double length_s = 0;
    std::array<std::array<double, 6>, kJoints> c{};
  };

  std::vector<Segment> segments_;
  Duration duration_{};
  PeakShares peaks_;
  JointVector start_{};
  JointVector goal_{};
};

}  // namespace twin::reference
