#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/teleoperator_config.h"
#include "twin/teleop/twist_bounds.h"

namespace twin::teleop {

/// The end effector's reference x_d. Follows a commanded twist or pose within bounds of twist,
/// acceleration and jerk.
///
/// AddTo() keeps it in its workspace: each bounded direction (the box's axes, the shoulder's
/// radius, the lead over the measured end effector) permits the speed from which a quarter of the
/// acceleration stops at the bound (reference/closing_speed.h). ShapedVelocity follows the twist
/// that the bounds leave, and x_d integrates it. A commanded pose adds an outer loop:
///   u = e / |e| min(ClosingSpeed(|e|), V),   e the pose error.
/// From outside the workspace only inward motion is possible.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class ShapedPose {
 public:
  ShapedPose(const MotionBounds& along, const MotionBounds& about, const Workspace& workspace)
      : along_(along), about_(about), workspace_(workspace) {}

  /// Starts at rest at this pose.
  void Begin(const Transform& O_T_EE) noexcept TWIN_REALTIME;

  /// The twist that approaches a pose and reaches it at rest. @param T  period, s.
  [[nodiscard]] Vector6 TwistTowards(const Transform& O_T_wish,
                                     double T) const noexcept TWIN_REALTIME;

  /// Adds the workspace's bounds of the commanded twist.
  /// @param lead  of the reference over the measured end effector, base axes, m and rad. @param T
  /// s, > 0.
  void AddTo(TwistBounds& bounds, const Vector6& lead, double T) const noexcept TWIN_REALTIME;

  /// Advances one period. @param twist  allowed, base axes. @param T  s, > 0.
  const reference::PoseTarget& Next(const Vector6& twist, double T) noexcept TWIN_REALTIME;

  /// Advances one period with this very twist. Next() goes on from rest.
  const reference::PoseTarget& Follow(const Vector6& twist, double T) noexcept TWIN_REALTIME;

  [[nodiscard]] const reference::PoseTarget& target() const noexcept { return target_; }
  [[nodiscard]] bool rests() const noexcept { return along_.rests() && about_.rests(); }
  /// As ShapedVelocity::nearly_rests().
  [[nodiscard]] bool nearly_rests() const noexcept {
    return along_.nearly_rests() && about_.nearly_rests();
  }

 private:
  const reference::PoseTarget& Move(const Vector6& twist, double T) noexcept;

  ShapedVelocity<3> along_;
  ShapedVelocity<3> about_;
  Workspace workspace_;
  reference::PoseTarget target_{};
};

}  // namespace twin::teleop
