#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Largest stiffness of the internal joint impedance controller, Nm/rad. Source: FCI protocol 5,
/// SetJointImpedance.
inline constexpr double kMaxJointStiffness = 14250;

/// Everything INT, the robot's own controller, is parametrised with. Defaults are the Panda's with
/// a Franka Hand, where published; the joint limits are data of the robot and have none.
struct IntConfig {
  JointLimits limits;

  /// Stiffness of the internal joint impedance controller, Nm/rad, each in
  /// [0, kMaxJointStiffness].
  JointVector K_theta{3000, 3000, 3000, 2500, 2500, 2000, 2000};
  /// Damping ratio of that controller, in (0, 2]. The robot's own is not public.
  double damping_ratio = 1.0;
  /// Reflected rotor inertia that INT's feed-forward and damping take into account, kg m^2, >= 0.
  JointVector rotor_inertia{};
  /// Share of the joints' residual friction that INT compensates, in [0, 1]; see
  /// FrictionCompensation. The robot's own compensation is not public; what it leaves is that
  /// residual, by definition, so nothing of it is compensated unless asked for.
  double friction_compensation = 0;
  /// Largest measured torque |tau_J| at which a motion goes on, Nm, each in (0, 1000]; absent:
  /// 1.2 tau_max. The range of the real sensors is not public; this one leaves room above what the
  /// drives can apply for what contact and inertia add.
  std::optional<JointVector> tau_J_range{};

  /// End effector: mass, centre of mass and inertia in flange axes.
  model::Payload end_effector;
  /// Nominal end effector in the flange frame.
  Transform F_T_NE = kIdentityTransform;

  /// Lost commands in a row that end the motion.
  std::uint32_t abort_after_lost = 20;
  /// Cycles after the start of a motion within which its first command must come. Not public; a
  /// prudent bound, so that a client that dies between Move and its first command does not block
  /// the robot for ever.
  std::uint32_t first_command_timeout_cycles = 1000;
  /// Largest distance of the first q_c from q_d, rad. Not public; what a simulator of the
  /// successor uses.
  double start_pose_tolerance_rad = 0.1;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::onboard
