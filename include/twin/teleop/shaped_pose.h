#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/pose_target.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// The end effector's reference x_d: follows a wished twist or pose within bounds of twist,
/// acceleration and jerk, and stays in its workspace.
///
/// The wished twist is cut, along each way that is bounded (the box's axes, the shoulder's radius,
/// how far ahead of the measured end effector it may be), to the speed from which a quarter of the
/// acceleration stops it at the border (reference/closing_speed.h); what remains, ShapedVelocity
/// follows, and x_d integrates. A wished pose is one more such loop, around it:
///   u = e / |e| min(ClosingSpeed(|e|), V),   e the way to it.
/// Who begins outside the workspace may only go in.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class ShapedPose {
 public:
  ShapedPose(const MotionBounds& along, const MotionBounds& about, const Workspace& workspace)
      : along_(along), about_(about), workspace_(workspace) {}

  /// At rest, there.
  void Begin(const Transform& O_T_EE) noexcept TWIN_REALTIME;

  /// The twist by which a pose is approached so that it is reached at rest. @param T  period, s.
  [[nodiscard]] Vector6 TwistTowards(const Transform& O_T_wish,
                                     double T) const noexcept TWIN_REALTIME;

  /// One period on. @param twist  wished, base axes. @param O_T_EE  measured. @param T  s, > 0.
  const reference::PoseTarget& Next(const Vector6& twist, const Transform& O_T_EE,
                                    double T) noexcept TWIN_REALTIME;

  [[nodiscard]] const reference::PoseTarget& target() const noexcept { return target_; }
  [[nodiscard]] bool rests() const noexcept { return along_.rests() && about_.rests(); }
  /// As ShapedVelocity's.
  [[nodiscard]] bool nearly_rests() const noexcept {
    return along_.nearly_rests() && about_.nearly_rests();
  }
  /// Whether a border took most of the last wish away.
  [[nodiscard]] bool at_border() const noexcept { return at_border_; }

 private:
  ShapedVelocity<3> along_;
  ShapedVelocity<3> about_;
  Workspace workspace_;
  reference::PoseTarget target_{};
  bool at_border_ = false;
};

}  // namespace twin::teleop
