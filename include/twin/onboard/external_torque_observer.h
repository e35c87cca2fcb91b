#pragma once

#include "twin/core/body_interface.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Estimates the external joint torques with an observer of the generalised momentum p = M(q) dq,
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - (p(k) - p(k-1)) / T + C^T dq - g - r(k-1)).
/// With C^T dq = dM/dt dq - C dq, and dM/dt taken over the cycle like p, the change of M cancels,
/// which leaves the first-order low-pass
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - M (dq(k) - dq(k-1)) / T - C dq - g - r(k-1)),
/// with M, C dq and g at q(k-1), dq(k-1), and tau_J of the cycle that began there. It takes one
/// recursion per cycle and has no integral that could drift.
///
/// Positive when the robot pushes on its environment: M ddq + C dq + g = tau_J - tau_ext_hat. tau_J
/// is measured behind the gear, so it contains no rotor inertia. It contains the friction of the
/// links, which looks like a push of up to about 1 Nm per joint in motion and zero at rest. Source
/// of the observer: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, "Collision detection and safe
/// reaction with the DLR-III lightweight manipulator arm", IROS 2006; of the sign: FCI protocol 5,
/// robot state.
///
/// Zero from Reset() until the first Update(). Skips cycles with sensors that are not finite.
/// Threads: one. Real-time: noexcept, allocates nothing.
class ExternalTorqueObserver {
 public:
  /// @param gain  K, 1/s, > 0.
  explicit ExternalTorqueObserver(double gain) noexcept;

  /// Restarts at zero. @param q  of the sensors.
  void Reset(const JointSensors& sensors, const model::Configuration& q) noexcept TWIN_REALTIME;

  /// Advances by one cycle. @param q  of the sensors. @param payload  end effector and load.
  void Update(const JointSensors& sensors, const model::Configuration& q,
              const model::Payload& payload) noexcept TWIN_REALTIME;

  [[nodiscard]] const JointVector& tau_ext_hat() const noexcept { return tau_ext_hat_; }  ///< Nm

 private:
  double share_;  ///< weight of a cycle's residual: 1 - e^(-K T)
  model::Configuration last_q_;
  JointVector last_dq_{};
  JointVector tau_ext_hat_{};
};

}  // namespace twin::onboard
