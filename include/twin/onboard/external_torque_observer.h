#pragma once

#include "twin/core/body_interface.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Estimates the joint torques between robot and environment, from which INT tells contacts:
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - M (dq(k) - dq(k-1)) / T - C dq - g - r(k-1)),
/// where r is tau_ext_hat, K the gain, T = 1 ms, M the mass matrix, C dq the Coriolis torque and g
/// the gravity torque of the model at q(k-1), dq(k-1), and tau_J the measured torque of the cycle
/// that began there. One recursion per cycle, without an integral that could drift.
///
/// This equals the observer of the generalised momentum p = M(q) dq,
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - (p(k) - p(k-1)) / T + C^T dq - g - r(k-1)),
/// if C^T dq = dM/dt dq - C dq takes dM/dt over the cycle, as p is: the change of M cancels.
///
/// Positive when the robot pushes on its environment: M ddq + C dq + g = tau_J - tau_ext_hat. tau_J
/// is measured behind the gear, so it contains no rotor inertia. It contains the friction of the
/// links, which looks like a push of up to about 1 Nm per joint in motion and zero at rest. Source
/// of the observer: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, "Collision detection and safe
/// reaction with the DLR-III lightweight manipulator arm", IROS 2006; of the sign: FCI protocol 5,
/// robot state.
///
/// Zero from Reset() until the first Update(). A cycle with a NaN or infinity among the sensors
/// leaves the estimate unchanged.
/// Threads: one. Real-time: noexcept, allocates nothing.
class ExternalTorqueObserver {
 public:
  /// @param arm  the model. @param gain  K, 1/s, > 0.
  ExternalTorqueObserver(const model::ArmModel& arm, double gain) noexcept;

  /// Restarts at zero. @param q  of the sensors.
  void Reset(const JointSensors& sensors, const model::Configuration& q) noexcept TWIN_REALTIME;

  /// Advances by one cycle. @param q  of the sensors. @param payload  end effector and load.
  void Update(const JointSensors& sensors, const model::Configuration& q,
              const model::Payload& payload) noexcept TWIN_REALTIME;

  [[nodiscard]] const JointVector& tau_ext_hat() const noexcept { return tau_ext_hat_; }  ///< Nm

 private:
  model::ArmModel arm_;
  double share_;  ///< weight of a cycle's residual: 1 - e^(-K T)
  model::Configuration last_q_;
  JointVector last_dq_{};
  JointVector tau_ext_hat_{};
};

}  // namespace twin::onboard
