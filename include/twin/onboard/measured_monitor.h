#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_interface.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// How far what is measured may go. None of these figures is public; each says why it is what it
/// is.
struct MeasuredBounds {
  /// Beyond the commanded positions' limits, rad, >= 0. An arm that follows an admissible reference
  /// to the very limit overshoots by up to 3 mrad.
  double q_margin_rad = 0.01;
  /// Share of the commanded velocities' limits, joint and rotation, by which measured ones may be
  /// above them, >= 0. An arm that follows an admissible reference is above it by less than 1 %
  /// with joint impedance, by up to 6 % with Cartesian impedance near a singularity.
  double velocity_margin = 0.1;
  /// Velocity of the end effector in any motion, m/s, > 0: the velocity that libfranka's rate
  /// limiter starts from. 1.7 m/s is what a Cartesian motion may command.
  double translation_max_m_per_s = 2.0;
  /// Mechanical power of the controller's torque, W, > 0. Less than half of what all drives could
  /// give at their largest torque and velocity (850 W); the trajectories of models/scenarios take
  /// up to 60 W, an unloaded arm whose seven joints accelerate at their limit, at their limit of
  /// velocity, on average 210 W.
  double power_max_W = 400;
  /// Range of the torque sensors, Nm, each > 0; absent: 1.2 tau_max, which leaves room above what
  /// the drives can apply for what contact and inertia add.
  std::optional<JointVector> tau_J_range;
  /// Least distance between parts of the arm, m, >= 0: their shapes are known to about as much.
  double clearance_m = 0.01;
  /// Whether a Franka Hand is on the flange, as a part that can meet others.
  bool has_hand = true;
};

/// INT's checks of what the sensors show, whatever was commanded:
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
/// v and w are of EE, g of arm, end effector and load. Each error is reported with the first joint
/// or axis that breaks it; all are looked at in every cycle, each has a cause of its own. What is
/// not finite is beyond its limit.
///
/// Decisions. The turning of EE is checked in Cartesian motions alone: the limits of the joints
/// allow a joint motion far more than those of Cartesian motions (joint 7 on its own turns by 2.61
/// rad/s), and nothing tells that joint motions are held to them. The velocity of the end
/// effector's point is looked at always, so that a joint motion with the arm stretched out can
/// break it. Power is what the drives put into the arm; what they take
/// out of it in braking is not limited.
///
/// Threads: any (immutable). Real-time: all but the constructor; noexcept, allocates nothing.
class MeasuredMonitor {
 public:
  MeasuredMonitor(const JointLimits& joints, const CartesianLimits& cartesian,
                  const MeasuredBounds& bounds) noexcept;

  /// What a cycle shows.
  struct Measured {
    JointSensors sensors;
    JointVector g{};           ///< gravity of arm, end effector and load, Nm
    Vector6 O_dP_EE{};         ///< twist of EE, base axes, m/s and rad/s
    double self_distance = 0;  ///< m, or a lower bound that is not below the clearance
  };

  /// @param tau_J_d  that acts, without gravity, Nm.
  /// @param is_cartesian  the motion is one of a Cartesian motion generator.
  [[nodiscard]] Violations Check(const Measured& measured, const JointVector& tau_J_d,
                                 bool is_cartesian,
                                 std::uint64_t message_id) const noexcept TWIN_REALTIME;

  [[nodiscard]] double clearance_m() const noexcept { return clearance_; }

  /// Whether a joint is beyond the limits of its measured position.
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
