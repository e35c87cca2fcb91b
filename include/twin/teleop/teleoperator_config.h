#pragma once

#include "twin/control/parameters.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/faults/message_fate.h"
#include "twin/teleop/shaped_velocity.h"

namespace twin::teleop {

/// Interpretation of a device's axes.
struct MappingConfig {
  double dead_zone = 0.05;  ///< ignored share of full scale, in [0, 0.5]
  double fine = 0.25;       ///< scale of fine motion, in [0.01, 1]
  /// Motion of the end effector per motion of a handle (kPose), in [0.01, 10].
  double pose_scale = 1;
  /// Displacement (m) and rotation (rad) of a handle (kPose) for full speed of the base, > 0.
  double full_way = 0.1;
  double full_turn = 0.5;
  bool operator==(const MappingConfig&) const = default;
};

/// Bounds of the arm's reference, in the base frame.
struct Workspace {
  Vector3 low{-0.4, -0.75, -0.6};  ///< m, of the end effector's origin
  Vector3 high{0.85, 0.75, 1.0};
  double nearest = 0.25;   ///< m, from the shoulder (0, 0, 0.333 m)
  double farthest = 0.85;  ///< m, from the shoulder
  /// Largest lead of the reference over a blocked end effector, m and rad; times the stiffness, it
  /// bounds the force that an operator can apply.
  double press = 0.04;
  double wring = 0.25;
  /// The operator may touch fixed bodies of the scene: they do not bound the motion. An impact or a
  /// press beyond the robot's collision thresholds then ends it.
  bool touch = false;
  bool operator==(const Workspace&) const = default;
};

/// Scaling of the external wrench that the operator feels.
struct FeedbackConfig {
  double scale = 0.3;         ///< of the wrench, in [0, 10]; 0: none
  double cutoff_hz = 10;      ///< of the low-pass, in [0.1, 500]
  double dead_force = 4;      ///< N, subtracted: the observer's residual on a free arm
  double dead_torque = 1.5;   ///< Nm
  double most_force = 5;      ///< N at the handle, > 0
  double most_torque = 0.3;   ///< Nm at the handle, > 0
  bool passive = true;        ///< false: for experiments only
  double reserve = 0.02;      ///< J per axis that the port may give in advance, > 0
  double damping = 20;        ///< largest damping that repays an energy debt, Ns/m, > 0
  double turn_damping = 0.1;  ///< Nms/rad, > 0
  /// Displacement that full deflection of a stick (kRate) stands for, m and rad.
  double stick_way = 0.01;
  double stick_turn = 0.15;
  bool operator==(const FeedbackConfig&) const = default;
};

/// Configuration of teleoperation.
struct TeleoperatorConfig {
  Duration stale_after = std::chrono::milliseconds(200);  ///< without a sample, in [10 ms, 10 s]
  MotionBounds along{.speed = 0.25, .acceleration = 2, .jerk = 60};     ///< end effector, m
  MotionBounds about{.speed = 0.8, .acceleration = 6, .jerk = 200};     ///< end effector, rad
  MotionBounds joint{.speed = 0.5, .acceleration = 2, .jerk = 60};      ///< turned alone, rad
  MotionBounds ahead{.speed = 0.6, .acceleration = 0.6, .jerk = 6};     ///< base, m
  MotionBounds turning{.speed = 0.8, .acceleration = 1.0, .jerk = 10};  ///< base, rad
  MappingConfig mapping{};
  Workspace workspace{};
  FeedbackConfig feedback{};

  /// @throws InputError naming field, value and range.
  void Validate() const;
  bool operator==(const TeleoperatorConfig&) const = default;
};

/// Faults of the messages between operator and robot.
struct WireConfig {
  faults::DirectionConfig to_robot{};
  faults::DirectionConfig from_robot{};
};

/// Reads a configuration from a scenario's parameters. Keys are the dotted field names; the bounds
/// are arm.along, arm.about, arm.joint, base.ahead, base.turning.
/// @throws InputError as ParameterReader's functions.
[[nodiscard]] TeleoperatorConfig ReadTeleoperatorConfig(control::ParameterReader& parameters);

}  // namespace twin::teleop
