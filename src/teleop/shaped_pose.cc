#include "twin/teleop/shaped_pose.h"

#include <algorithm>

#include <Eigen/Core>

#include "twin/model/transform.h"
#include "twin/reference/closing_speed.h"

namespace twin::teleop {
namespace {

using Eigen::Vector3d;
using reference::ClosingSpeed;

const Vector3d kShoulder(0, 0, 0.333);    // m, intersection of the axes of joints 1 to 3
constexpr double kOfAcceleration = 0.25;  // share for one bound, because several may act at once
constexpr double kNothing = 1e-9;         // m, rad

/// Largest speed towards a bound, from the distance left.
struct Brake {
  double deceleration;
  double omega;
  [[nodiscard]] double Most(double left) const noexcept {
    return ClosingSpeed(std::max(left, 0.0), deceleration, omega);
  }
};

/// Limits the component of u along a unit vector.
void Cut(Vector3d& u, const Vector3d& along, double most) noexcept {
  const double speed = u.dot(along);
  if (speed > most) u -= (speed - most) * along;
}

void CutAtBox(Vector3d& u, const Vector3d& p, const Workspace& w, const Brake& brake) noexcept {
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    u[i] = std::clamp(u[i], -brake.Most(p[i] - w.low[axis]), brake.Most(w.high[axis] - p[i]));
  }
}

void CutAtShell(Vector3d& u, const Vector3d& p, const Workspace& w, const Brake& brake) noexcept {
  const Vector3d out = p - kShoulder;
  const double distance = out.norm();
  if (distance < kNothing) return;
  const Vector3d n = out / distance;
  Cut(u, n, brake.Most(w.farthest - distance));
  Cut(u, -n, brake.Most(distance - w.nearest));
}

/// @param lead  lead of the reference over the end effector.
void CutAtLead(Vector3d& u, const Vector3d& lead, double most, const Brake& brake) noexcept {
  const double distance = lead.norm();
  if (distance > kNothing) Cut(u, lead / distance, brake.Most(most - distance));
}

bool TookMost(const Vector3d& wished, const Vector3d& left, double full) noexcept {
  constexpr double kWorthIt = 0.02;
  return wished.norm() > kWorthIt * full && left.norm() < wished.norm() / 2;
}

}  // namespace

void ShapedPose::Begin(const Transform& O_T_EE) noexcept {
  along_.Rest();
  about_.Rest();
  target_ = {O_T_EE, {}};
  at_border_ = false;
}

Vector6 ShapedPose::TwistTowards(const Transform& O_T_wish, double T) const noexcept {
  const auto towards = [T](const Vector3d& e, const ShapedVelocity<3>& shaped) -> Vector3d {
    const double distance = e.norm();
    if (distance < kNothing) return Vector3d::Zero();
    const double speed =
        ClosingSpeed(distance, shaped.bounds().acceleration / 2, shaped.PositionOmega(T));
    return e * (std::min(speed, shaped.bounds().speed) / distance);
  };
  const Vector3d v = towards(model::Position(O_T_wish) - model::Position(target_.O_T_EE), along_);
  const Vector3d w = towards(model::TurnBetween(target_.O_T_EE, O_T_wish), about_);
  return {v[0], v[1], v[2], w[0], w[1], w[2]};
}

const reference::PoseTarget& ShapedPose::Next(const Vector6& twist, const Transform& O_T_EE,
                                              double T) noexcept {
  const Vector3d p = model::Position(target_.O_T_EE);
  const auto brake_of = [T](const ShapedVelocity<3>& shaped) {
    return Brake{kOfAcceleration * shaped.bounds().acceleration, shaped.PositionOmega(T)};
  };
  const Vector3d v_wished =
      ShapedVelocity<3>::Limited({twist[0], twist[1], twist[2]}, along_.bounds().speed);
  const Vector3d w_wished =
      ShapedVelocity<3>::Limited({twist[3], twist[4], twist[5]}, about_.bounds().speed);
  Vector3d v = v_wished;
  Vector3d w = w_wished;
  const Brake along = brake_of(along_);
  CutAtLead(v, p - model::Position(O_T_EE), workspace_.press, along);
  CutAtShell(v, p, workspace_, along);
  CutAtBox(v, p, workspace_, along);
  CutAtLead(w, model::TurnBetween(O_T_EE, target_.O_T_EE), workspace_.wring, brake_of(about_));
  at_border_ =
      TookMost(v_wished, v, along_.bounds().speed) || TookMost(w_wished, w, about_.bounds().speed);
  v = along_.Next(v, T);
  w = about_.Next(w, T);
  target_.O_T_EE = model::Turned(target_.O_T_EE, T * w, p + T * v);
  target_.O_dP_EE = {v[0], v[1], v[2], w[0], w[1], w[2]};
  return target_;
}

}  // namespace twin::teleop
