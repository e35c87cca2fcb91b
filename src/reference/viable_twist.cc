#include "twin/reference/viable_twist.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference {
namespace {

using Eigen::Vector3d;

constexpr double kTwistInside = 1e-6;  ///< share by which enforced bounds are inside the given ones
constexpr int kTwistHalvings = 30;

void RequireSoundTwist(const CartesianBound& bound, int lost, std::string_view name) {
  RequireMagnitude(name, "dp_max", bound.dp_max);
  RequireMagnitude(name, "ddp_max", bound.ddp_max);
  RequireMagnitude(name, "dddp_max", bound.dddp_max);
  RequireLost(lost);
  constexpr double kMostSteps = 1000;
  if (bound.ddp_max > kMostSteps * kT * bound.dddp_max) {
    throw InputError(fmt::format(
        "viability filter: {}: at a jerk of {:.4g} it takes more than {} commands to end an "
        "acceleration of {:.4g}; raise dddp_max",
        name, bound.dddp_max, kMostSteps, bound.ddp_max));
  }
}

/// `x`, or the nearest point of the ball about `centre`.
Vector3d IntoBall(const Vector3d& x, const Vector3d& centre, double radius) noexcept {
  const Vector3d way = x - centre;
  const double distance = way.norm();
  return distance <= radius ? x : Vector3d(centre + way * (radius / distance));
}

}  // namespace

ViableTwist::ViableTwist(const CartesianBound& bound, int lost, std::string_view name)
    : lost_((RequireSoundTwist(bound, lost, name), lost)),
      kept_{bound.dp_max * (1 - kTwistInside), bound.ddp_max * (1 - kTwistInside),
            bound.dddp_max * (1 - kTwistInside)} {
  const double gathered = Gathered(kept_.ddp_max);
  if (kept_.dp_max >= gathered) return;
  throw InputError(fmt::format(
      "viability filter: {}: its velocity limit of {:.4g} is gathered within {} lost commands; at "
      "least {:.4g} is needed at these limits. Lower its acceleration",
      name, kept_.dp_max, lost_, gathered));
}

double ViableTwist::Gathered(double acceleration) const noexcept {
  double velocity = 0;
  while (acceleration > 0) {
    velocity += lost_ * kT * acceleration;
    acceleration = std::max(acceleration - kT * kept_.dddp_max, 0.0);
    velocity += kT * acceleration;
  }
  return velocity;
}

bool ViableTwist::Contains(const Vector3d& v, const Vector3d& a) const noexcept {
  const double acceleration = a.norm();
  if (!(acceleration <= kept_.ddp_max && v.norm() <= kept_.dp_max)) return false;
  if (acceleration == 0) return true;
  return (v + a * (Gathered(acceleration) / acceleration)).norm() <= kept_.dp_max;
}

bool ViableTwist::Allows(const Vector3d& v, const Vector3d& a, const Vector3d& v_c) const noexcept {
  const Vector3d a_c = (v_c - v) / kT;
  return (a_c - a).norm() <= kT * kept_.dddp_max && Contains(v_c, a_c);
}

Vector3d ViableTwist::Braked(const Vector3d& v, const Vector3d& a) const noexcept {
  const double acceleration = a.norm();
  // Slightly below J, so that rounding does not exceed it.
  const double step = kT * kept_.dddp_max * (1 - 1e-9);
  if (!(acceleration > step)) return v;
  return v + kT * (1 - step / acceleration) * a;
}

Vector3d ViableTwist::Nearest(const Vector3d& v, const Vector3d& a,
                              const Vector3d& wish) const noexcept {
  if (Allows(v, a, wish)) return wish;
  Vector3d braked = Braked(v, a);
  if (!wish.allFinite()) return braked;
  const Vector3d a_wish =
      IntoBall(IntoBall((wish - v) / kT, Vector3d::Zero(), kept_.ddp_max), a, kT * kept_.dddp_max);
  const Vector3d way = v + kT * a_wish - braked;
  double keeps = 0;
  double breaks = 1;
  for (int i = 0; i < kTwistHalvings; ++i) {
    const double middle = (keeps + breaks) / 2;
    (Allows(v, a, braked + middle * way) ? keeps : breaks) = middle;
  }
  return braked + keeps * way;
}

Vector3d ViableTwist::Slowed(const Vector3d& v, const Vector3d& a) const noexcept {
  const double speed = v.norm();
  if (speed == 0) return Nearest(v, a, v);
  const double braking = std::min(kept_.ddp_max, speed / (4 * kT));
  return Nearest(v, a, v * (1 - kT * braking / speed));
}

}  // namespace twin::reference
