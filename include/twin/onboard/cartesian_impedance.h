#pragma once

#include "twin/core/body_interface.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/measured_arm.h"

namespace twin::onboard {

/// INT's internal Cartesian impedance controller: a spring and a damper between the measured and
/// the desired stiffness frame K, along and about the axes of K.
///
///   tau_J_d = (M + B) ddq_d + c(q, dq) + J^T (K_x e + D_x J (dq_d - dq)) + N^T tau_n
///   tau     = tau_J_d + g(q)
///
/// J is the Jacobian of K in its own axes at q. e = [p_d - p; log(R^T R_d)] leads from the measured
/// to the desired pose of K (that of q_d), in the axes of the measured K. B is the rotor inertia.
/// The reference is a joint reference in every motion; with the feed-forward of ddq_d the arm
/// follows an admissible one without lag, as with JointImpedance.
///
/// Damping. D_x is diagonal, D_ii = 2 zeta sqrt(K_ii min(Lambda_ii, Lambda_max)), where Lambda = (J
/// (M + B)^-1 J^T)^-1 is the inertia at K with the rotors: critical along each axis while the
/// others are at rest. Lambda_max = 50 kg and 5 kg m^2 bounds the damping near singularities, where
/// Lambda grows without bound.
///
/// Null space. tau_n = K_n (q_d - q) + D_n (dq_d - dq) holds the arm at q_d with K_n = 200 Nm/rad
/// in every joint; D_n is critical for M_ii + B_ii. N^T tau_n = tau_n - J^T F, F = Lambda J (M +
/// B)^-1 tau_n, removes what would act on K (Khatib 1987), so that a constant force at K deflects
/// it through K_x alone. Near a singularity, where an axis of K is heavier than 100 kg or 10 kg
/// m^2, F gradually leaves out the directions heavier than about 200 kg or 20 kg m^2: K hardly
/// moves along them and its spring hardly holds them, so tau_n holds them.
///
/// The torque is not limited here: INT cuts every torque to tau_max. Source of the structure: FCI
/// protocol 5, control law (tracks O_T_EE_d with K_x in K). Damping and null space of the real
/// robot are not public; ours are decisions.
///
/// Threads: any (immutable). Real-time: noexcept, allocates nothing.
class CartesianImpedance {
 public:
  /// @param K_x  N/m and Nm/rad, >= 0. @param damping_ratio  zeta. @param rotor_inertia  B, kg m^2.
  CartesianImpedance(const Vector6& K_x, double damping_ratio, const JointVector& rotor_inertia)
      : K_x_(K_x), damping_ratio_(damping_ratio), rotor_inertia_(rotor_inertia) {}

  /// @param O_T_EE_d  pose of EE at q_d. @param measured  the arm at the measured q.
  [[nodiscard]] ImpedanceTorque Torque(const JointReference& reference, const Transform& O_T_EE_d,
                                       const JointSensors& sensors, const MeasuredArm& measured,
                                       const model::ArmModel& arm,
                                       const ArmSetup& setup) const noexcept TWIN_REALTIME;

 private:
  Vector6 K_x_;
  double damping_ratio_;
  JointVector rotor_inertia_;
};

}  // namespace twin::onboard
