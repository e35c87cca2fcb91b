#pragma once

#include "twin/core/body_interface.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/measured_arm.h"

namespace twin::onboard {

/// Torque of INT's internal joint impedance controller.
struct ImpedanceTorque {
  JointVector tau_J_d{};  ///< without gravity, as in the robot state, Nm
  JointVector tau{};      ///< applied by the drives: with gravity compensation, Nm
};

/// INT's internal joint impedance controller:
///   tau_J_d = (M(q) + B) ddq_d + c(q, dq) + K_theta (q_d - q) + D (dq_d - dq),
///   tau     = tau_J_d + g(q),
///   D_ii    = 2 zeta sqrt(K_theta_ii (M_ii(q) + B_ii)),
/// B the reflected rotor inertia. With the feed-forward of ddq_d the arm follows an admissible
/// reference without lag; it uses the reference as INT holds it, including extrapolated cycles.
/// FrictionCompensation acts afterwards. Source of the structure: the paper's section on FCI timing
/// (torque from B(q), C, f, g). Damping and gains of the robot are not public; ours are decisions.
///
/// Threads: any (immutable). Real-time: noexcept, allocates nothing.
class JointImpedance {
 public:
  JointImpedance(const JointVector& K_theta, double damping_ratio, const JointVector& rotor_inertia)
      : K_theta_(K_theta), damping_ratio_(damping_ratio), rotor_inertia_(rotor_inertia) {}

  /// @param measured  the arm at the measured q.
  [[nodiscard]] ImpedanceTorque Torque(const JointReference& reference, const JointSensors& sensors,
                                       const MeasuredArm& measured, const model::ArmModel& arm,
                                       const ArmSetup& setup) const noexcept TWIN_REALTIME;

 private:
  JointVector K_theta_;
  double damping_ratio_;
  JointVector rotor_inertia_;
};

}  // namespace twin::onboard
