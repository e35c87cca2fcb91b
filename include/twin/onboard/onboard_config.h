#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/model/lab_limits.h"
#include "twin/onboard/sensing.h"

namespace twin::onboard {

/// Configuration of INT, the robot's controller. Defaults are those of the Panda with a Franka
/// Hand, where published. Limits are robot data and have no default.
struct OnboardConfig {
  JointLimits limits;  ///< that commands are checked against
  CartesianLimits cartesian;
  /// The joints' limits in what INT moves by itself (stops, goals); absent: `limits`. Narrower
  /// where those allow for the rounding of a client's positions.
  std::optional<JointLimits> own_limits;
  /// The arm's rigid-body model, by which INT reckons gravity, inertia and contacts.
  model::ArmModel arm = model::ArmModel::Panda();
  /// Whether states have accelerometer values (FR3).
  bool has_accelerometers = false;

  /// Initial values of what setters change.
  setting::JointImpedance joint_impedance;
  setting::CartesianImpedance cartesian_impedance;
  setting::CollisionBehavior collision_behavior;
  setting::GuidingMode guiding_mode;
  setting::StiffnessFrame stiffness_frame;
  setting::EndEffectorFrame end_effector_frame;
  setting::Load load;
  setting::Filters filters;

  /// Damping ratio of the internal controllers, in (0, 2]. The robot's is not public.
  double damping_ratio = 1.0;
  /// Reflected rotor inertia for INT's feed-forward and damping, kg m^2, >= 0.
  JointVector rotor_inertia{};
  /// Share of the joints' residual friction that INT compensates, in [0, 1]; see
  /// FrictionCompensation. The robot's compensation is not public; the residual is by definition
  /// what it leaves, so the default is 0.
  double friction_compensation = 0;

  /// End effector: mass, centre of mass and inertia in flange axes.
  model::Payload end_effector;
  /// Nominal end effector in the flange frame.
  Transform F_T_NE = kIdentityTransform;

  /// Consecutive lost commands that end the motion.
  std::uint32_t abort_after_lost = 20;
  /// Cycles within which a motion's first command must arrive. Not public; chosen so that a client
  /// that dies between Move and its first command does not block the robot forever.
  std::uint32_t first_command_timeout_cycles = 1000;
  /// Largest distances between a motion's first command and the reference. Not public; the values
  /// of a simulator of the robot's successor.
  double start_pose_tolerance_rad = 0.1;  ///< |q_c - q_d|
  double start_translation_tolerance_m = 0.05;
  double start_rotation_tolerance_rad = 0.1;
  double start_elbow_tolerance_rad = 0.1;

  /// Limits of a lab that INT keeps by itself (OnboardController, "Guard"); empty, as on every real
  /// robot: none.
  model::LabLimits guard;
  bool guard_has_hand = true;  ///< a Franka Hand is mounted, which the guard's regions limit

  /// Bounds of measured quantities; its limits are replaced by those above.
  SensingConfig sensing;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::onboard
