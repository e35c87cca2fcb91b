#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// Bounds on measured quantities. None is public; each comment gives the reason for its value.
struct MeasuredBounds {
  /// Margin beyond the limits of commanded positions, rad, >= 0. An arm that follows an admissible
  /// reference up to the limit overshoots by up to 3 mrad.
  double q_margin_rad = 0.01;
  /// Relative margin above the limits of commanded velocities, for joints and rotation, >= 0. An
  /// arm that follows an admissible reference exceeds them by less than 1 % with joint impedance,
  /// and by up to 6 % with Cartesian impedance near a singularity.
  double velocity_margin = 0.1;
  /// Speed of the end effector in any motion, m/s, > 0: the value on which libfranka's rate limiter
  /// is based. A Cartesian motion may command 1.7 m/s.
  double translation_max_m_per_s = 2.0;
  /// Mechanical power of the controller's torque, W, > 0. It is below half of what all drives give
  /// at their largest torque and velocity (850 W). The trajectories of models/scenarios take up to
  /// 60 W; an unloaded arm with all seven joints at their velocity limit and accelerating at their
  /// limit takes 210 W on average.
  double power_max_W = 400;
  /// Range of the torque sensors, Nm, each > 0. Default: 1.2 tau_max, to leave room for contact and
  /// inertia above the torque of the drives.
  std::optional<JointVector> tau_J_range;
  /// Least distance between parts of the arm, m, >= 0; about the accuracy of their shapes.
  double clearance_m = 0.01;
  /// Whether a Franka Hand on the flange takes part in self-collision.
  bool has_hand = true;
};

/// INT's checks of the sensor values, independent of commands:
///
/// | error | holds while | value, limit, axis |
/// |---|---|---|
/// | joint_position_limits_violation | q_min - margin <= q <= q_max + margin | q, rad; joint |
/// | joint_velocity_violation | abs(dq) <= (1 + margin) dq_max | dq, rad/s; joint |
/// | cartesian_velocity_violation | abs(v) <= translation_max | abs(v), m/s; 0 |
/// | | abs(w) <= (1 + margin) w_max, in Cartesian motions | abs(w), rad/s; 1 |
/// | self_collision_avoidance_violation | SelfDistance(q) >= clearance | distance, m; none |
/// | power_limit_violation | sum (tau_J_d + g)_i dq_i <= power_max | power, W; none |
/// | tau_J_range_violation | abs(tau_J) <= tau_J_range | tau_J, Nm; joint |
///
/// v and w are of EE; g is of arm, end effector and load. Each error is reported with the first
/// joint or axis that breaks it. All checks run independently in every cycle. A value that is not
/// finite violates its limit.
///
/// Decisions. The rotation of EE is checked in Cartesian motions only: the joint limits allow much
/// more (joint 7 alone rotates by 2.61 rad/s), and no source holds joint motions to the Cartesian
/// limits. The speed of the end effector's point is always checked, so a joint motion with a
/// stretched arm can violate it. Power counts only what the drives feed into the arm; the power
/// they absorb in braking is not limited.
///
/// Threads: any (immutable). Real-time: all but the constructor; noexcept, allocates nothing.
class MeasuredMonitor {
 public:
  MeasuredMonitor(const JointLimits& joints, const CartesianLimits& cartesian,
                  const MeasuredBounds& bounds) noexcept;

  /// Measured quantities of a cycle.
  struct Measured {
    JointSensors sensors;
    JointVector g{};           ///< gravity of arm, end effector and load, Nm
    Vector6 O_dP_EE{};         ///< twist of EE, base axes, m/s and rad/s
    double self_distance = 0;  ///< m, or a lower bound of at least the clearance
  };

  /// @param tau_J_d  applied, without gravity, Nm.
  /// @param is_cartesian  a Cartesian motion generator runs.
  [[nodiscard]] Violations Check(const Measured& measured, const JointVector& tau_J_d,
                                 bool is_cartesian,
                                 std::uint64_t message_id) const noexcept TWIN_REALTIME;

  [[nodiscard]] double clearance_m() const noexcept { return clearance_; }

  /// Whether a joint is beyond its measured position limits.
  [[nodiscard]] bool IsOutOfRange(const JointVector& q) const noexcept TWIN_REALTIME;

 private:
  void CheckJoints(const JointSensors& sensors, std::uint64_t message_id,
                   Violations& found) const noexcept;
  void CheckVelocity(const Measured& measured, bool is_cartesian, std::uint64_t message_id,
                     Violations& found) const noexcept;
  void CheckPower(const Measured& measured, const JointVector& tau_J_d, std::uint64_t message_id,
                  Violations& found) const noexcept;

  JointVector q_min_{};
  JointVector q_max_{};
  JointVector dq_max_{};
  double v_max_;
  double w_max_;
  double power_max_;
  JointVector tau_J_range_{};
  double clearance_;
};

}  // namespace twin::onboard
