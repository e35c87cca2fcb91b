#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/pose_target.h"
#include "twin/reference/trajectory.h"

namespace twin::reference {

/// One pose the end effector comes to.
struct PoseWaypoint {
  Transform O_T_EE = kIdentityTransform;  ///< rotation orthonormal within 1e-5
  /// Time from the start; given for all poses (strictly rising, the first 0) or for none.
  std::optional<Duration> at{};
  std::string where{};  ///< where it was read ("press.yaml:14"), for messages; may be empty
};

/// A path of the end effector through poses, at rest in each of them. From pose (R_0, p_0) to
/// (R_1, p_1), in the time L from t_0 on:
///   p(t) = p_0 + s (p_1 - p_0),   R(t) = exp(s phi) R_0,   phi = log(R_1 R_0^T),
///   s = 10 x^3 - 15 x^4 + 6 x^5,   x = (t - t_0) / L:
/// a straight line and the shortest turn about one axis (as slerp), both by minimum jerk. The peaks
/// of a distance d (|p_1 - p_0| or |phi|) are known: 15/8 d / L, 10/sqrt(3) d / L^2, 60 d / L^3.
/// Each must stay within kAdmissibleShare of the limits of the end effector's motion. Joints and
/// their limits are not looked at. Two equal poses with different times: it stands.
///
/// Untimed: each piece takes the shortest time that keeps to the shares of the limits; with a
/// duration all times are then stretched by one factor. Times are whole nanoseconds.
///
/// Threads: immutable after construction, any thread. Real-time: Sample() is noexcept, O(log
/// poses), allocates nothing.
class PoseTrajectory {
 public:
  /// @param limits  valid (CartesianLimits::Validate).
  /// @throws InputError when: fewer than two poses, or more than kMaxWaypoints; one is no pose; a
  /// turn is half a revolution, so that there is no shortest way; only some have a time, or times
  /// do not rise from 0; two neighbours of an untimed path coincide; a share or the duration is
  /// out of range; a limit is broken. The text names the pose, the value, the limit and the cure.
  PoseTrajectory(const std::vector<PoseWaypoint>& waypoints, const Timing& timing,
                 const CartesianLimits& limits);

  /// Total time.
  [[nodiscard]] Duration duration() const noexcept { return duration_; }

  /// @param t  time since the start; before 0 the first pose at rest, after duration() the last
  /// pose at rest, both bit for bit.
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
