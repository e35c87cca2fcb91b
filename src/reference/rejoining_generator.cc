#include "twin/reference/rejoining_generator.h"

#include <algorithm>
#include <cmath>

#include "twin/core/time.h"
#include "twin/reference/closing_speed.h"

namespace twin::reference {
namespace {

constexpr double kT = kCycleSeconds;

/// Of position, velocity and acceleration, 1/s: each loop four times faster than the one around it.
constexpr double kOmega1 = 25;
constexpr double kOmega2 = 100;
constexpr double kOmega3 = 400;

/// Share of the correction's acceleration by which it comes to rest: what is left of it, should the
/// source begin to accelerate meanwhile.
constexpr double kBraking = RejoiningGenerator::kShare;

double Saturated(double x, double most) noexcept {
  return std::clamp(x, -most, most);
}

}  // namespace

RejoiningGenerator::RejoiningGenerator(const JointLimits& limits) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    limits_[i] = {limits.dq_max[i], limits.ddq_max[i], limits.dddq_max[i]};
  }
}

RejoiningGenerator::Bounds RejoiningGenerator::LeftBy(double v, double a,
                                                      const Bounds& limits) noexcept {
  return {std::max(kVelocityShare * limits.v, kMostShare * limits.v - std::abs(v)),
          std::max(kShare * limits.a, kMostShare * limits.a - std::abs(a)), kShare * limits.j};
}

void RejoiningGenerator::Reset(const JointVector& q_d) noexcept {
  r_.fill(q_d);
}

void RejoiningGenerator::Observe(const JointVector& r) noexcept {
  std::move_backward(r_.begin(), r_.end() - 1, r_.end());
  r_[0] = r;
}

double RejoiningGenerator::Jerk(double e, double de, double dde, const Bounds& most) noexcept {
  const double speed = std::min(ClosingSpeed(std::abs(e), kBraking * most.a, kOmega1), most.v);
  const double acceleration = Saturated(kOmega2 * (-std::copysign(speed, e) - de), most.a);
  return Saturated(kOmega3 * (acceleration - dde), most.j);
}

JointVector RejoiningGenerator::Next(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d) const noexcept {
  JointVector q_c{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double v = (r_[1][i] - r_[2][i]) / kT;
    const double a = (v - (r_[2][i] - r_[3][i]) / kT) / kT;
    const double e = q_d[i] - r_[1][i];
    const double de = dq_d[i] - v;
    const double dde = ddq_d[i] - a;
    const double jerk = Jerk(e, de, dde, LeftBy(v, a, limits_[i]));
    q_c[i] = r_[0][i] + e + kT * (de + kT * (dde + kT * jerk));
  }
  return q_c;
}

}  // namespace twin::reference
