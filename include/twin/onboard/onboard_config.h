#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/sensing.h"

namespace twin::onboard {

/// Everything INT, the robot's own controller, is parametrised with. Defaults are the Panda's with
/// a Franka Hand, where published; the limits are data of the robot and have none.
struct OnboardConfig {
  JointLimits limits;
  CartesianLimits cartesian;

  /// What the setters change, as it stands when the robot starts.
  setting::JointImpedance joint_impedance;
  setting::CartesianImpedance cartesian_impedance;
  setting::CollisionBehavior collision_behavior;
  setting::GuidingMode guiding_mode;
  setting::StiffnessFrame stiffness_frame;
  setting::EndEffectorFrame end_effector_frame;
  setting::Load load;
  setting::Filters filters;

  /// Damping ratio of the internal controllers, in (0, 2]. The robot's own is not public.
  double damping_ratio = 1.0;
  /// Reflected rotor inertia that INT's feed-forward and damping take into account, kg m^2, >= 0.
  JointVector rotor_inertia{};
  /// Share of the joints' residual friction that INT compensates, in [0, 1]; see
  /// FrictionCompensation. The robot's own compensation is not public; what it leaves is that
  /// residual, by definition, so nothing of it is compensated unless asked for.
  double friction_compensation = 0;

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
  /// Largest distances of a motion's first command from the reference. Not public; what a simulator
  /// of the successor uses.
  double start_pose_tolerance_rad = 0.1;  ///< |q_c - q_d|
  double start_translation_tolerance_m = 0.05;
  double start_rotation_tolerance_rad = 0.1;
  double start_elbow_tolerance_rad = 0.1;

  /// Bounds of what is measured. Its limits are those above, whatever it holds.
  SensingConfig sensing;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::onboard
