#include "twin/onboard/sensing.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::onboard {

void SensingConfig::Validate() const {
  RequireInRange("onboard: sensing: observer_gain", observer_gain, 1e-3, 1000);
  RequireInRange("onboard: sensing: wrench_gain_max", wrench_gain_max, 1e-3, 1e6);
  RequireInRange("onboard: sensing: q_margin_rad", measured.q_margin_rad, 0, 1);
  RequireInRange("onboard: sensing: velocity_margin", measured.velocity_margin, 0, 10);
  RequireInRange("onboard: sensing: translation_max_m_per_s", measured.translation_max_m_per_s,
                 1e-3, 100);
  RequireInRange("onboard: sensing: power_max_W", measured.power_max_W, 1e-3, 1e6);
  RequireInRange("onboard: sensing: clearance_m", measured.clearance_m, 0, 1);
  if (!measured.tau_J_range) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("onboard: sensing: tau_J_range[{}]", i), (*measured.tau_J_range)[i],
                   1e-6, 1000);
  }
}

Sensing::Sensing(const SensingConfig& config) noexcept
    : wrench_gain_max_(config.wrench_gain_max),
      model_(config.arm),
      observer_(config.arm, config.observer_gain),
      monitor_(config.joints, config.cartesian, config.measured),
      self_distance_(config.measured.has_hand) {}

void Sensing::SetCollisionBehavior(const setting::CollisionBehavior& behavior) noexcept {
  contacts_.SetBehavior(behavior);
}

void Sensing::Reset(const JointSensors& sensors, const ArmSetup& setup) noexcept {
  Measure(sensors, setup);
  observer_.Reset(sensors, arm_.q);
  wrench_ = ExternalWrench();
  contacts_.Update(observer_.tau_ext_hat(), wrench_.K_F_ext_hat_K, false);
}

void Sensing::Update(const JointSensors& sensors, const ArmSetup& setup,
                     bool accelerates) noexcept {
  Measure(sensors, setup);
  observer_.Update(sensors, arm_.q, setup.payload);
  wrench_ = EstimateWrench(observer_.tau_ext_hat(), arm_.EE.J, arm_.EE.O_T_frame, setup.EE_T_K,
                           wrench_gain_max_);
  contacts_.Update(observer_.tau_ext_hat(), wrench_.K_F_ext_hat_K, accelerates);
}

void Sensing::Measure(const JointSensors& sensors, const ArmSetup& setup) noexcept {
  arm_ = MeasuredArm(model_, sensors.q, setup);
  measured_.sensors = sensors;
  measured_.g = arm_.g;
  measured_.O_dP_EE = Vector6{};
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    for (std::size_t row = 0; row < 6; ++row) {
      measured_.O_dP_EE[row] += arm_.EE.J[6 * joint + row] * sensors.dq[joint];
    }
  }
  measured_.self_distance = self_distance_.Update(sensors.q, arm_.q, monitor_.clearance_m());
}

Violations Sensing::Collisions(std::uint64_t message_id) const noexcept {
  return contacts_.Collisions(message_id);
}

Violations Sensing::CheckMeasured(const JointVector& tau_J_d, std::uint64_t message_id,
                                  bool is_cartesian) const noexcept {
  return monitor_.Check(measured_, tau_J_d, is_cartesian, message_id);
}

void Sensing::ClearCollisions() noexcept {
  contacts_.Clear();
}

bool Sensing::NeedsManualRecovery() const noexcept {
  return monitor_.IsOutOfRange(measured_.sensors.q);
}

const JointVector& Sensing::tau_ext_hat_filtered() const noexcept {
  return observer_.tau_ext_hat();
}

const Vector6& Sensing::O_F_ext_hat_K() const noexcept {
  return wrench_.O_F_ext_hat_K;
}

const Vector6& Sensing::K_F_ext_hat_K() const noexcept {
  return wrench_.K_F_ext_hat_K;
}

const JointVector& Sensing::joint_contact() const noexcept {
  return contacts_.joint_contact();
}

const Vector6& Sensing::cartesian_contact() const noexcept {
  return contacts_.cartesian_contact();
}

const JointVector& Sensing::joint_collision() const noexcept {
  return contacts_.joint_collision();
}

const Vector6& Sensing::cartesian_collision() const noexcept {
  return contacts_.cartesian_collision();
}

}  // namespace twin::onboard
