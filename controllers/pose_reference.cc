#include "controllers/pose_reference.h"

#include <string>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/model/transform.h"

namespace twin::controllers {
namespace {

constexpr double kStartDistance = 5e-3;  // m
constexpr double kStartAngle = 0.02;     // rad

}  // namespace

void PoseReference::Configure(control::ParameterReader& parameters, bool may_be_live) {
  const std::string kind = may_be_live
                               ? parameters.Choice("reference", "path", {"path", "hold", "live"})
                               : parameters.Choice("reference", "path", {"path", "hold"});
  holds_ = kind == "hold";
  is_live_ = kind == "live";
  if (!is_live_ || request_.live != nullptr) return;
  parameters.Refuse("reference",
                    "live needs an operator, and this run has none: use the application "
                    "teleoperation");
}

void PoseReference::Begin(const JointVector& q, const Transform& F_T_EE, Time now,
                          std::string_view who) {
  F_T_EE_ = F_T_EE;
  held_ = request_.arm.Pose(model::Frame::kEndEffector, q, F_T_EE);
  if (is_live_) {
    request_.live->Begin(held_, now);
    return;
  }
  const Vector6 way = model::WayTo(held_, Sample(Duration::zero()).O_T_EE);
  const double distance = HalfNorm(way, 0);
  const double angle = HalfNorm(way, 3);
  if (distance <= kStartDistance && angle <= kStartAngle) return;
  throw InputError(fmt::format(
      "{}: the end effector is {:.4f} m and {:.4f} rad from where the path begins; {} m and {} rad "
      "are allowed. Move the robot there, or let the path begin where the robot is",
      who, distance, angle, kStartDistance, kStartAngle));
}

reference::PoseTarget PoseReference::Next(const RobotState& state, Time now,
                                          Duration t) const noexcept {
  return is_live_ ? request_.live->Next(state, now) : Sample(t);
}

bool PoseReference::IsOver(Duration t) const noexcept {
  return is_live_ ? request_.live->finished() : t >= duration();
}

reference::PoseTarget PoseReference::Sample(Duration t) const noexcept {
  if (holds_) return {held_, {}};
  if (request_.poses != nullptr) return request_.poses->Sample(t);
  const reference::JointTarget target = request_.trajectory.Sample(t);
  const model::Configuration q(target.q);
  return {request_.arm.Pose(model::Frame::kEndEffector, q, F_T_EE_),
          request_.arm.Twist(model::Frame::kEndEffector, q, target.dq, F_T_EE_)};
}

}  // namespace twin::controllers
