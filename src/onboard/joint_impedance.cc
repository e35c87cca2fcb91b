#include "twin/onboard/joint_impedance.h"

#include <cmath>

namespace twin::onboard {

ImpedanceTorque JointImpedance::Torque(const JointReference& reference, const JointSensors& sensors,
                                       const MeasuredArm& measured, const model::ArmModel& arm,
                                       const ArmSetup& setup) const noexcept {
  constexpr Vector3 kNoGravity{0, 0, 0};
  const JointVector& q = sensors.q;
  const JointVector& dq = sensors.dq;
  const JointVector dynamics =
      arm.InverseDynamics(measured.q, dq, reference.ddq_d, setup.payload, kNoGravity);
  const model::JointMatrix M = arm.MassMatrix(measured.q, setup.payload);

  ImpedanceTorque torque;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double B = rotor_inertia_[i];
    const double D = 2 * damping_ratio_ * std::sqrt(K_theta_[i] * (M[i * kJoints + i] + B));
    torque.tau_J_d[i] = dynamics[i] + B * reference.ddq_d[i] +
                        K_theta_[i] * (reference.q_d[i] - q[i]) + D * (reference.dq_d[i] - dq[i]);
    torque.tau[i] = torque.tau_J_d[i] + measured.g[i];
  }
  return torque;
}

}  // namespace twin::onboard
