#include "twin/onboard/external_torque_observer.h"

#include <cmath>

#include "twin/core/time.h"

namespace twin::onboard {

ExternalTorqueObserver::ExternalTorqueObserver(const model::ArmModel& arm, double gain) noexcept
    : arm_(arm), share_(-std::expm1(-gain * kCycleSeconds)), last_q_(JointVector{}) {}

void ExternalTorqueObserver::Reset(const JointSensors& sensors,
                                   const model::Configuration& q) noexcept {
  last_q_ = q;
  last_dq_ = sensors.dq;
  tau_ext_hat_ = JointVector{};
}

void ExternalTorqueObserver::Update(const JointSensors& sensors, const model::Configuration& q,
                                    const model::Payload& payload) noexcept {
  JointVector ddq;
  for (std::size_t i = 0; i < kJoints; ++i) {
    ddq[i] = (sensors.dq[i] - last_dq_[i]) / kCycleSeconds;
  }
  const JointVector tau_model = arm_.InverseDynamics(last_q_, last_dq_, ddq, payload);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double residual = sensors.tau_J[i] - tau_model[i] - tau_ext_hat_[i];
    if (std::isfinite(residual)) tau_ext_hat_[i] += share_ * residual;
  }
  last_q_ = q;
  last_dq_ = sensors.dq;
}

}  // namespace twin::onboard
