#include "controllers/pose_reference.h"

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/core/error.h"
#include "twin/core/half_norm.h"
#include "twin/model/rotation.h"

namespace twin::controllers {
namespace {

constexpr double kStartDistance = 5e-3;  // m
constexpr double kStartAngle = 0.02;     // rad

}  // namespace

void PoseReference::Configure(control::ParameterReader& parameters) {
  holds_ = parameters.Choice("reference", "path", {"path", "hold"}) == "hold";
}

void PoseReference::Begin(const JointVector& q, const Transform& F_T_EE, std::string_view who) {
  F_T_EE_ = F_T_EE;
  held_ = request_.arm.Pose(model::Frame::kEndEffector, q, F_T_EE);
  const Vector6 way = WayTo(held_, Sample(Duration::zero()).O_T_EE);
  const double distance = HalfNorm(way, 0);
  const double angle = HalfNorm(way, 3);
  if (distance <= kStartDistance && angle <= kStartAngle) return;
  throw InputError(fmt::format(
      "{}: the end effector is {:.4f} m and {:.4f} rad from where the path begins; {} m and {} rad "
      "are allowed. Move the robot there, or let the path begin where the robot is",
      who, distance, angle, kStartDistance, kStartAngle));
}

reference::PoseTarget PoseReference::Sample(Duration t) const noexcept {
  if (holds_) return {held_, {}};
  if (request_.poses != nullptr) return request_.poses->Sample(t);
  const reference::JointTarget target = request_.trajectory.Sample(t);
  const model::Configuration q(target.q);
  return {request_.arm.Pose(model::Frame::kEndEffector, q, F_T_EE_),
          request_.arm.Twist(model::Frame::kEndEffector, q, target.dq, F_T_EE_)};
}

Vector6 WayTo(const Transform& X, const Transform& X_d) noexcept {
  const Eigen::Vector3d p = model::Position(X_d) - model::Position(X);
  const Eigen::Vector3d phi = model::TurnBetween(X, X_d);
  return {p[0], p[1], p[2], phi[0], phi[1], phi[2]};
}

}  // namespace twin::controllers
