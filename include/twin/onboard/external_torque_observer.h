#pragma once

#include "twin/core/joint_interface.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Estimates what acts on the joints from outside: an observer of the generalised momentum
/// p = M(q) dq,
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - (p(k) - p(k-1)) / T + C^T dq - g - r(k-1)).
/// With C^T dq = dM/dt dq - C dq, and dM/dt taken over the cycle as p is, the change of M cancels
/// and what is left is the first-order low-pass
///   r(k) = r(k-1) + (1 - e^(-K T)) (tau_J - M (dq(k) - dq(k-1)) / T - C dq - g - r(k-1)),
/// M, C dq and g at q(k-1), dq(k-1): tau_J is that of the cycle that began there. One recursion a
/// cycle, no integral that could drift.
///
/// Positive when the robot pushes on its environment: M ddq + C dq + g = tau_J - tau_ext_hat. tau_J
/// is measured behind the gear, so there is no rotor inertia in it; what the links lose to friction
/// is in it and looks like a push, up to about 1 Nm a joint in motion and nothing at rest. Source
/// of the observer: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, "Collision detection and safe
/// reaction with the DLR-III lightweight manipulator arm", IROS 2006; of the sign: FCI protocol 5,
/// robot state.
///
/// Zero until the first Update() after a Reset(). A cycle whose sensors are not finite is left out.
/// Threads: one. Real-time: noexcept, allocates nothing.
class ExternalTorqueObserver {
 public:
  /// @param gain  K, 1/s, > 0.
  explicit ExternalTorqueObserver(double gain) noexcept;

  /// Starts anew, at zero. @param q  of the sensors.
  void Reset(const JointSensors& sensors, const model::Configuration& q) noexcept TWIN_REALTIME;

  /// One cycle on. @param q  of the sensors. @param payload  end effector and load.
  void Update(const JointSensors& sensors, const model::Configuration& q,
              const model::Payload& payload) noexcept TWIN_REALTIME;

  [[nodiscard]] const JointVector& tau_ext_hat() const noexcept { return tau_ext_hat_; }  ///< Nm

 private:
  double share_;  ///< of a cycle's residual: 1 - e^(-K T)
  model::Configuration last_q_;
  JointVector last_dq_{};
  JointVector tau_ext_hat_{};
};

}  // namespace twin::onboard
