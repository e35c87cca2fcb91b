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

double Saturated(double x, double most) noexcept {
  return std::clamp(x, -most, most);
}

}  // namespace

RejoiningGenerator::RejoiningGenerator(const JointLimits& limits) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    most_[i] = {kVelocityShare * limits.dq_max[i], kShare * limits.ddq_max[i],
                kShare * limits.dddq_max[i]};
  }
}

void RejoiningGenerator::Reset(const JointVector& q_d) noexcept {
  r_.fill(q_d);
}

void RejoiningGenerator::Observe(const JointVector& r) noexcept {
  std::move_backward(r_.begin(), r_.end() - 1, r_.end());
  r_[0] = r;
}

double RejoiningGenerator::Jerk(double e, double de, double dde, const Bounds& most) noexcept {
  const double speed = std::min(ClosingSpeed(std::abs(e), most.a / 2, kOmega1), most.v);
  const double acceleration = Saturated(kOmega2 * (-std::copysign(speed, e) - de), most.a);
  return Saturated(kOmega3 * (acceleration - dde), most.j);
}

JointVector RejoiningGenerator::Next(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d) const noexcept {
  JointVector q_c{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double v = (r_[1][i] - r_[2][i]) / kT;
    const double v_before = (r_[2][i] - r_[3][i]) / kT;
    const double e = q_d[i] - r_[1][i];
    const double de = dq_d[i] - v;
    const double dde = ddq_d[i] - (v - v_before) / kT;
    const double jerk = Jerk(e, de, dde, most_[i]);
    q_c[i] = r_[0][i] + e + kT * (de + kT * (dde + kT * jerk));
  }
  return q_c;
}

}  // namespace twin::reference
