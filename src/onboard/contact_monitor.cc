#include "twin/onboard/contact_monitor.h"

#include <cmath>

namespace twin::onboard {
namespace {

bool IsAbove(double value, double threshold) noexcept {
  return std::abs(value) > threshold * (1 + kLimitTolerance);
}

template <std::size_t n>
using Values = std::array<double, n>;

/// Contacts last as long as their cause; collisions are latched.
template <std::size_t n>
void Judge(const Values<n>& values, const Values<n>& lower, const Values<n>& upper,
           Values<n>& contact, Values<n>& collision) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    contact[i] = IsAbove(values[i], lower[i]) ? 1 : 0;
    if (IsAbove(values[i], upper[i])) collision[i] = 1;
  }
}

template <std::size_t n>
void AddFirst(RobotError error, const Values<n>& values, const Values<n>& upper,
              std::uint64_t message_id, Violations& found) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    if (!IsAbove(values[i], upper[i])) continue;
    found.Add({error, static_cast<std::int8_t>(i), values[i], std::copysign(upper[i], values[i]),
               message_id});
    return;
  }
}

}  // namespace

void ContactMonitor::Update(const JointVector& tau_ext_hat, const Vector6& K_F_ext_hat_K,
                            bool accelerates) noexcept {
  const setting::CollisionBehavior& b = behavior_;
  tau_ext_hat_ = tau_ext_hat;
  K_F_ext_hat_K_ = K_F_ext_hat_K;
  accelerates_ = accelerates;
  Judge(tau_ext_hat_, accelerates ? b.lower_torque_acc : b.lower_torque_nominal,
        accelerates ? b.upper_torque_acc : b.upper_torque_nominal, joint_contact_,
        joint_collision_);
  Judge(K_F_ext_hat_K_, accelerates ? b.lower_force_acc : b.lower_force_nominal,
        accelerates ? b.upper_force_acc : b.upper_force_nominal, cartesian_contact_,
        cartesian_collision_);
}

Violations ContactMonitor::Collisions(std::uint64_t message_id) const noexcept {
  Violations found;
  AddFirst(RobotError::kJointReflex, tau_ext_hat_,
           accelerates_ ? behavior_.upper_torque_acc : behavior_.upper_torque_nominal, message_id,
           found);
  AddFirst(RobotError::kCartesianReflex, K_F_ext_hat_K_,
           accelerates_ ? behavior_.upper_force_acc : behavior_.upper_force_nominal, message_id,
           found);
  return found;
}

void ContactMonitor::Clear() noexcept {
  joint_collision_ = JointVector{};
  cartesian_collision_ = Vector6{};
}

}  // namespace twin::onboard
