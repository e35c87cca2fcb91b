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

/// n . v <= most, or n . w <= most.
void Add(TwistBounds& bounds, const Vector3d& n, double most, Bound bound, bool turns = false) {
  Vector6 row{};
  for (std::size_t i = 0; i < 3; ++i) row[turns ? 3 + i : i] = n[static_cast<Eigen::Index>(i)];
  bounds.Add(row, most, {bound});
}

void AddBox(TwistBounds& bounds, const Vector3d& p, const Workspace& w, const Brake& brake) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    Add(bounds, Vector3d::Unit(i), brake.Most(w.high[axis] - p[i]), Bound::kWorkspace);
    Add(bounds, -Vector3d::Unit(i), brake.Most(p[i] - w.low[axis]), Bound::kWorkspace);
  }
}

void AddShell(TwistBounds& bounds, const Vector3d& p, const Workspace& w, const Brake& brake) {
  const Vector3d out = p - kShoulder;
  const double distance = out.norm();
  if (distance < kNothing) return;
  Add(bounds, out / distance, brake.Most(w.farthest - distance), Bound::kWorkspace);
  Add(bounds, -out / distance, brake.Most(distance - w.nearest), Bound::kWorkspace);
}

void AddLead(TwistBounds& bounds, const Vector3d& lead, double most, const Brake& brake,
             bool turns) {
  const double distance = lead.norm();
  if (distance < kNothing) return;
  Add(bounds, lead / distance, brake.Most(most - distance), Bound::kPress, turns);
}

}  // namespace

void ShapedPose::Begin(const Transform& O_T_EE) noexcept {
  along_.Rest();
  about_.Rest();
  target_ = {O_T_EE, {}};
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

void ShapedPose::AddTo(TwistBounds& bounds, const Vector6& lead, double T) const noexcept {
  const auto brake_of = [T](const ShapedVelocity<3>& shaped) {
    return Brake{kOfAcceleration * shaped.bounds().acceleration, shaped.PositionOmega(T)};
  };
  const Vector3d p = model::Position(target_.O_T_EE);
  const Brake along = brake_of(along_);
  AddBox(bounds, p, workspace_, along);
  AddShell(bounds, p, workspace_, along);
  AddLead(bounds, {lead[0], lead[1], lead[2]}, workspace_.press, along, false);
  AddLead(bounds, {lead[3], lead[4], lead[5]}, workspace_.wring, brake_of(about_), true);
}

const reference::PoseTarget& ShapedPose::Next(const Vector6& twist, double T) noexcept {
  const Vector3d v = along_.Next({twist[0], twist[1], twist[2]}, T);
  const Vector3d w = about_.Next({twist[3], twist[4], twist[5]}, T);
  return Move({v[0], v[1], v[2], w[0], w[1], w[2]}, T);
}

const reference::PoseTarget& ShapedPose::Follow(const Vector6& twist, double T) noexcept {
  along_.Rest();
  about_.Rest();
  return Move(twist, T);
}

const reference::PoseTarget& ShapedPose::Move(const Vector6& twist, double T) noexcept {
  target_.O_T_EE = model::Turned(target_.O_T_EE, T * model::Angular(twist),
                                 model::Position(target_.O_T_EE) + T * model::Linear(twist));
  target_.O_dP_EE = twist;
  return target_;
}

}  // namespace twin::teleop
