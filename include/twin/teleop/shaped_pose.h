#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// The end effector's reference x_d. Follows a commanded twist or pose within bounds of twist,
/// acceleration and jerk, and stays in its workspace.
///
/// Each bounded direction (the box's axes, the shoulder's radius, the lead over the measured end
/// effector) cuts the commanded twist to the speed from which a quarter of the acceleration stops
/// at the bound (reference/closing_speed.h). ShapedVelocity follows the result and x_d integrates
/// it. A commanded pose adds an outer loop:
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

  /// Advances one period. @param twist  commanded, base axes. @param O_T_EE  measured. @param T  s,
  /// > 0.
  const reference::PoseTarget& Next(const Vector6& twist, const Transform& O_T_EE,
                                    double T) noexcept TWIN_REALTIME;

  [[nodiscard]] const reference::PoseTarget& target() const noexcept { return target_; }
  [[nodiscard]] bool rests() const noexcept { return along_.rests() && about_.rests(); }
  /// As ShapedVelocity::nearly_rests().
  [[nodiscard]] bool nearly_rests() const noexcept {
    return along_.nearly_rests() && about_.nearly_rests();
  }
  /// True if a bound removed most of the last command.
  [[nodiscard]] bool at_border() const noexcept { return at_border_; }

 private:
  ShapedVelocity<3> along_;
  ShapedVelocity<3> about_;
  Workspace workspace_;
  reference::PoseTarget target_{};
  bool at_border_ = false;
};

}  // namespace twin::teleop
