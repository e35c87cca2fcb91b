#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::reference {

/// One point of a trajectory.
struct Waypoint {
  JointVector q{};  ///< rad
  /// Time from the start; set for all points (strictly increasing, the first 0) or for none.
  std::optional<Duration> at{};
  bool stop = false;    ///< come to rest here
  std::string where{};  ///< source location for messages ("canonical.yaml:14"); may be empty
};

/// Pace of an untimed trajectory. Each distance takes the time of its slowest joint at its velocity
/// limit; then one factor stretches all times. For timed points only `duration` is used: it must
/// equal the last point's time.
struct Timing {
  std::optional<Duration> duration{};  ///< total time, above 0
  /// Without a duration: the fastest uniform pace with peak velocity, acceleration and jerk within
  /// these shares of the limits, each in (0, 1].
  double velocity_scale = 0.5;
  double acceleration_scale = 0.2;
  double jerk_scale = 0.1;
};

/// Largest magnitude of a quantity over a trajectory, per joint, as a share of its limit.
struct PeakShares {
  JointVector velocity{};
  JointVector acceleration{};
  JointVector jerk{};
};

/// One quintic per joint on [begin, begin + length_s].
struct QuinticSegment {
  Duration begin{};                                ///< since the start of the trajectory
  double length_s = 0;                             ///< > 0
  std::array<std::array<double, 6>, kJoints> c{};  ///< q(t) = sum c[joint][i] x^i, x = t - begin
                                                   ///< in seconds; rad/s^i
};

/// The quintic sum c[i] x^i with these values, velocities and accelerations at x = 0 and x = h.
[[nodiscard]] std::array<double, 6> QuinticBetween(double q0, double dq0, double ddq0, double q1,
                                                   double dq1, double ddq1, double h) noexcept;

/// Largest share of a velocity, acceleration or jerk limit that a trajectory may use. The rest
/// covers rounding: a sampled position is accurate to about 4e-16 rad, so its third difference at 1
/// ms to 8 x 4e-16 rad / (1 ms)^3 = 3e-6 rad/s^3, below a thousandth of the rest of the smallest
/// jerk limit, 1e-6 x 3750 rad/s^3.
inline constexpr double kAdmissibleShare = 1.0 - 1e-6;

/// Least distance of a trajectory from the position limits, rad.
inline constexpr double kPositionMargin = 1e-9;

/// Largest distance of a motion's start from its trajectory's first point, rad per joint. A
/// reference generator with lambda = 1e-3 corrects it with a first step of 1e-6 rad, a jerk of 1e3
/// rad/s^3, within every joint's limit.
inline constexpr double kStartTolerance = 1e-3;

/// Most points of a trajectory: 100 s at 1 kHz. Keeps scenarios with inline points, and the logs
/// that contain them, within the limits of their readers.
inline constexpr std::size_t kMaxWaypoints = 100'000;

/// A joint-space path through waypoints: a quintic spline, at rest (dq = ddq = 0) at both ends and
/// at every stop, with continuous derivatives up to the fourth in between. Among all paths through
/// the points at these times it has the least integral of jerk squared.
///
/// Its jerk is bounded, so INT's backward differences at 1 ms, which average the derivatives over
/// one, two and three periods, never exceed the derivatives' peaks for any sampling phase. The
/// peaks are found at the roots of the next derivative, not by sampling, and must stay within
/// kAdmissibleShare of the limits.
///
/// Every point's time is a whole number of nanoseconds; computed times are rounded before the
/// spline is fitted. Construction is linear in the number of points (about 0.5 kB each).
///
/// Threads: immutable after construction, any thread. Real-time: Sample() is noexcept, O(log
/// points), allocates nothing.
class Trajectory {
 public:
  /// @param limits  valid (JointLimits::Validate).
  /// @throws InputError when: fewer than two points; a value is not finite; a point or the path is
  /// not inside the position limits by kPositionMargin; only some points have a time, or times do
  /// not increase from 0; two neighbours of an untimed path coincide; a share or the duration is
  /// out of range, or the total exceeds a day; the path exceeds a velocity, acceleration or jerk
  /// limit. The text names the point or time, joint, value, limit and the cure (e.g. the shortest
  /// admissible duration).
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
  std::vector<QuinticSegment> segments_;
  Duration duration_{};
  PeakShares peaks_;
  JointVector start_{};
  JointVector goal_{};
};

/// Largest accepted trajectory file, bytes.
inline constexpr std::uintmax_t kMaxTrajectoryFileBytes = std::uintmax_t{64} << 20;

/// Reads timed waypoints from a CSV file: the header line `time,q1,q2,q3,q4,q5,q6,q7`, then one
/// point per line, time in seconds from the start (rounded to nanoseconds, the first 0, strictly
/// increasing) and joint positions in rad. Numbers use a decimal point in any locale. Blanks around
/// a field, CRLF line ends, a byte order mark and empty lines at the end are accepted.
///
/// Each waypoint's `where` is file name and line.
///
/// @throws InputError naming file, line, column, the text found and the expected format, when: the
/// file is not regular, not readable or larger than kMaxTrajectoryFileBytes; the header differs; a
/// line has a wrong number of fields; a field is not a finite number; times do not increase from 0
/// or exceed a day; an empty line stands between points; there is no point.
[[nodiscard]] std::vector<Waypoint> ReadWaypointsCsv(const std::filesystem::path& path);

}  // namespace twin::reference
