#pragma once

#include <optional>
#include <string_view>

#include "twin/control/registry.h"
#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/reference/target.h"

namespace twin::controllers {

/// Reference of a pose controller: x_d(t), dx_d(t) of the end effector, t since the start of the
/// motion.
///   hold    the initial pose, at rest
///   poses   the motion's path of poses
///   joints  the motion's joint-space path: O_T_EE(q*(t)), J(q*(t)) dq*(t)
///   live    an operator's reference (control::LiveReference), which also ends the motion
/// After the path's end: its goal at rest. The end effector is the one in the robot's state at the
/// start of the motion.
///
/// Threads: one. Real-time: Sample() is noexcept and does not allocate.
class PoseReference {
 public:
  /// @param request  is copied; its referenced objects must outlive this object.
  explicit PoseReference(const control::ControllerRequest& request) : request_(request) {}

  /// Reads the parameter `reference`: "path" (poses, else joints), "hold" or "live".
  /// @param may_be_live  true if the controller supports a live reference: Next().
  /// @throws InputError as ParameterReader::Choice; for "live" without a live reference.
  void Configure(control::ParameterReader& parameters, bool may_be_live = false);

  /// @param q  measured joints, rad. @param F_T_EE  from the state.
  /// @param now  time of the controller's activation. @param who  controller's name in messages.
  /// @throws InputError if the end effector is not at the path's start (within 5 mm and 0.02 rad),
  /// or q is not finite.
  void Begin(const JointVector& q, const Transform& F_T_EE, Time now, std::string_view who);

  /// Call once per update, in order. @param t  since the first update.
  [[nodiscard]] reference::PoseTarget Next(const RobotState& state, Time now,
                                           Duration t) const noexcept TWIN_REALTIME;
  /// Of a live reference that has one: joint positions and velocities of the last pose.
  [[nodiscard]] std::optional<reference::JointTarget> posture() const noexcept TWIN_REALTIME {
    return is_live_ ? request_.live->posture() : std::nullopt;
  }
  /// True once the path has ended, or the operator has ended the motion.
  [[nodiscard]] bool IsOver(Duration t) const noexcept TWIN_REALTIME;

  /// For references that are not live.
  [[nodiscard]] reference::PoseTarget Sample(Duration t) const noexcept TWIN_REALTIME;
  /// Of the path, also for "hold".
  [[nodiscard]] Duration duration() const noexcept { return request_.trajectory.duration(); }
  [[nodiscard]] const Transform& F_T_EE() const noexcept { return F_T_EE_; }

 private:
  control::ControllerRequest request_;
  bool holds_ = false;
  bool is_live_ = false;
  Transform F_T_EE_ = kIdentityTransform;
  Transform held_ = kIdentityTransform;
};

}  // namespace twin::controllers
