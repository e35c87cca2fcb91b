#pragma once

#include <Eigen/Geometry>

#include "twin/core/body_interface.h"
#include "twin/core/realtime.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/onboard/measured_arm.h"

namespace twin::onboard {

/// Guiding: INT carries the arm's weight, and people lead the arm by hand along and about the free
/// axes. The other axes, and the null space unless it is free, are held where guiding began or
/// where the free axes have moved them.
///
///   tau_J_d = c(q, dq) + A^T (K e - D A dq) - D_q dq,   tau = tau_J_d + g(q)
///
/// A has a row per axis: those of the zero Jacobian of EE (base axes), and n^T for the null space,
/// n the unit vector with J n = 0. Along locked axes e leads back to the pose where guiding began,
/// whose coordinates along free axes move with the arm; for the null space e is -sum n^T (q(k) -
/// q(k-1)). Along free axes e is zero. K is 40000 N/m, 2000 Nm/rad about the axes, 1000 Nm/rad in
/// the null space: a push of 20 N moves a locked axis by half a millimetre. D of locked axes is
/// critical for the inertia (C (M + B)^-1 C^T)^-1, C the locked rows of A, up to 50 kg and 5 kg
/// m^2; D of free axes is light, 30 Ns/m and 3 Nms/rad, and couples into no other axis. D_q = 0.3
/// Nms/rad damps what no axis covers near a singularity. A released arm comes to rest within a
/// second or two.
///
/// Source: FCI protocol 5, SetGuidingMode. The law is not public; this one is a decision.
///
/// Threads: one. Real-time: all but the constructor; noexcept, allocates nothing.
class Guiding {
 public:
  /// @param rotor_inertia  B, kg m^2.
  explicit Guiding(const JointVector& rotor_inertia) noexcept : rotor_inertia_(rotor_inertia) {}

  /// Sets the free axes. An axis that becomes locked is held where it is.
  void SetMode(const setting::GuidingMode& mode) noexcept { mode_ = mode; }

  /// Starts guiding at q. @param q  measured.
  void Begin(const JointVector& q, const ArmSetup& setup) noexcept TWIN_REALTIME;

  /// @param measured  the arm at the measured q. @pre Begin() was called.
  [[nodiscard]] ImpedanceTorque Torque(const JointSensors& sensors, const MeasuredArm& measured,
                                       const model::ArmModel& arm,
                                       const ArmSetup& setup) noexcept TWIN_REALTIME;

 private:
  using Axes = Eigen::Matrix<double, 7, 1>;  ///< six of the base, and the null space

  [[nodiscard]] Axes Follow(const Transform& O_T_EE) noexcept;
  [[nodiscard]] bool IsLocked(int axis) const noexcept;

  JointVector rotor_inertia_;
  setting::GuidingMode mode_;
  Eigen::Vector3d held_position_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond held_orientation_ = Eigen::Quaterniond::Identity();
  Axes null_vector_ = Axes::Zero();  ///< n of the last cycle; zero before the first
  double null_error_ = 0;            ///< e_n, rad
  JointVector last_q_{};
};

}  // namespace twin::onboard
