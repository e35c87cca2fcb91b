#include "twin/reference/stall_decay.h"

#include <cstddef>

#include "reference/saturated_correction.h"
#include "twin/core/time.h"

namespace twin::reference {
namespace {

constexpr double kTorqueDecay = 10;  // 1/s

/// Velocities below this count as zero; dropping one is a jerk of 0.1 rad/s^3.
constexpr double kGone = 1e-7;

/// One cycle of D values at `v`, with their accelerations at `a`.
template <int D>
void DecayVelocity(double* v, double* a, const CartesianBound& limits) noexcept {
  using Vector = Eigen::Matrix<double, D, 1>;
  Eigen::Map<Vector> velocity(v);
  Eigen::Map<Vector> acceleration(a);
  const Vector next = CorrectingVelocity<D>(Vector::Zero(), velocity, acceleration, 0, 0, limits);
  const bool is_gone = next.norm() < kGone;
  acceleration = is_gone ? Vector(Vector::Zero()) : Vector((next - velocity) / kT);
  velocity = is_gone ? Vector(Vector::Zero()) : next;
}

}  // namespace

StallDecay::StallDecay(const JointLimits& joints, const CartesianLimits& cartesian) noexcept
    : cartesian_(cartesian) {
  for (std::size_t i = 0; i < kJoints; ++i) joints_[i] = BoundOf(joints, i);
}

void StallDecay::Follow(const Target& target) noexcept {
  target_ = target;
  ddq_ = {};
  O_ddP_EE_ = {};
}

void StallDecay::Decay() noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    DecayVelocity<1>(&target_.joint.dq[i], &ddq_[i], joints_[i]);
    target_.tau_J_d[i] *= 1 - kTorqueDecay * kT;
  }
  DecayVelocity<3>(target_.pose.O_dP_EE.data(), O_ddP_EE_.data(), cartesian_.translation);
  DecayVelocity<3>(target_.pose.O_dP_EE.data() + 3, O_ddP_EE_.data() + 3, cartesian_.rotation);
}

}  // namespace twin::reference
