#pragma once

#include <string_view>

#include "twin/control/controller_request.h"
#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/reference/pose_target.h"

namespace twin::controllers {

/// What a controller of poses follows: x_d(t), dx_d(t) of the end effector, t since the motion
/// began.
///   hold    the pose in which the arm is found, at rest
///   poses   the motion's path of poses
///   joints  the motion's path through joint space: O_T_EE(q*(t)), J(q*(t)) dq*(t)
///   live    whoever leads (control::LiveReference); it is his to end the motion
/// After the path's end its goal at rest. The end effector is the robot's, as its state has it when
/// the motion begins.
///
/// Threads: one. Real-time: Sample() is noexcept and allocates nothing.
class PoseReference {
 public:
  /// @param request  is copied; what it refers to outlives this.
  explicit PoseReference(const control::ControllerRequest& request) : request_(request) {}

  /// Takes the parameter `reference`: "path" (poses, else joints), "hold" or "live".
  /// @param may_be_live  whether the controller follows one: Next().
  /// @throws InputError as ParameterReader::Choice; for "live" when nobody leads.
  void Configure(control::ParameterReader& parameters, bool may_be_live = false);

  /// @param q  where the arm is, rad. @param F_T_EE  of the state.
  /// @param now  of the controller's activation. @param who  for messages.
  /// @throws InputError when the end effector is not where the path begins (within 5 mm and 0.02
  /// rad), or q is not finite.
  void Begin(const JointVector& q, const Transform& F_T_EE, Time now, std::string_view who);

  /// Of an update, in order. @param t  since the first one.
  [[nodiscard]] reference::PoseTarget Next(const RobotState& state, Time now,
                                           Duration t) const noexcept TWIN_REALTIME;
  /// Whether that was the end: the path's, or whoever leads has ended it.
  [[nodiscard]] bool IsOver(Duration t) const noexcept TWIN_REALTIME;

  /// Of a reference that is not live.
  [[nodiscard]] reference::PoseTarget Sample(Duration t) const noexcept TWIN_REALTIME;
  /// Of the path, also while holding.
  [[nodiscard]] Duration duration() const noexcept { return request_.trajectory.duration(); }
  [[nodiscard]] const Transform& F_T_EE() const noexcept { return F_T_EE_; }

 private:
  control::ControllerRequest request_;
  bool holds_ = false;
  bool is_live_ = false;
  Transform F_T_EE_ = kIdentityTransform;
  Transform held_ = kIdentityTransform;
};

/// The way from pose X to pose X_d: [p_d - p; log(R_d R^T)], base axes, m and rad.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Vector6 WayTo(const Transform& X, const Transform& X_d) noexcept TWIN_REALTIME;

}  // namespace twin::controllers
