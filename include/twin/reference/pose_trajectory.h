#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"
#include "twin/reference/trajectory.h"

namespace twin::reference {

/// One pose of the end effector's path.
struct PoseWaypoint {
  Transform O_T_EE = kIdentityTransform;  ///< rotation orthonormal within 1e-5
  /// Time from the start; set for all poses (strictly increasing, the first 0) or for none.
  std::optional<Duration> at{};
  std::string where{};  ///< source location for messages ("press.yaml:14"); may be empty
};

/// A path of the end effector through poses, at rest in each. From pose (R_0, p_0) to (R_1, p_1),
/// in the time L from t_0 on:
///   p(t) = p_0 + s (p_1 - p_0),   R(t) = exp(s phi) R_0,   phi = log(R_1 R_0^T),
///   s = 10 x^3 - 15 x^4 + 6 x^5,   x = (t - t_0) / L:
/// a straight line and the shortest rotation about one axis (slerp), both with minimum jerk. The
/// peaks for a distance d (|p_1 - p_0| or |phi|) are 15/8 d / L, 10/sqrt(3) d / L^2, 60 d / L^3.
/// Each must stay within kAdmissibleShare of the limits of the end effector's motion. Joints and
/// their limits are not checked. Two equal poses at different times are a pause.
///
/// Untimed: each segment takes the shortest time within the shares of the limits; with a duration,
/// one factor then stretches all times. Times are whole nanoseconds.
///
/// Threads: immutable after construction, any thread. Real-time: Sample() is noexcept, O(log
/// poses), allocates nothing.
class PoseTrajectory {
 public:
  /// @param limits  valid (CartesianLimits::Validate).
  /// @throws InputError when: fewer than two poses, or more than kMaxWaypoints; a pose is invalid;
  /// a rotation is half a turn (no shortest direction); only some poses have a time, or times do
  /// not increase from 0; two neighbours of an untimed path coincide; a share or the duration is
  /// out of range; a limit is exceeded. The text names pose, value, limit and cure.
  PoseTrajectory(const std::vector<PoseWaypoint>& waypoints, const Timing& timing,
                 const CartesianLimits& limits);

  /// Total time.
  [[nodiscard]] Duration duration() const noexcept { return duration_; }

  /// @param t  time since the start; before 0 exactly the first pose at rest, after duration()
  /// exactly the last.
  [[nodiscard]] PoseTarget Sample(Duration t) const noexcept TWIN_REALTIME;

  [[nodiscard]] const Transform& start() const noexcept { return segments_.front().from; }
  [[nodiscard]] const Transform& goal() const noexcept { return goal_; }

 private:
  struct Segment {
    Duration begin{};
    double length_s = 0;
    Transform from = kIdentityTransform;
    Vector3 way{};  ///< p_1 - p_0, m
    Vector3 phi{};  ///< base axes, rad
  };

  std::vector<Segment> segments_;
  Duration duration_{};
  Transform goal_ = kIdentityTransform;
};

}  // namespace twin::reference
