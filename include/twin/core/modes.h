#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "twin/core/joint_vector.h"

namespace twin {

/// Mode of the robot. Values are those of the robot state on the wire. Source: FCI protocol 5.
enum class RobotMode : std::uint8_t {
  kOther = 0,
  kIdle = 1,
  kMove = 2,
  kGuiding = 3,
  kReflex = 4,
  kUserStopped = 5,
  kAutomaticErrorRecovery = 6,
};

/// Source of the reference in a motion. Values are those of the robot *state* (a Move request
/// numbers them one lower).
enum class MotionGeneratorMode : std::uint8_t {
  kIdle = 0,
  kJointPosition = 1,
  kJointVelocity = 2,
  kCartesianPosition = 3,
  kCartesianVelocity = 4,
  kNone = 5,  ///< torque alone, with an external controller; FCI protocol 10
};

/// Whether commands to the generator are poses or twists.
[[nodiscard]] constexpr bool IsCartesian(MotionGeneratorMode mode) noexcept {
  return mode == MotionGeneratorMode::kCartesianPosition ||
         mode == MotionGeneratorMode::kCartesianVelocity;
}

/// Controller that converts the reference to torque. kOther is shown without a motion.
enum class ControllerMode : std::uint8_t {
  kJointImpedance = 0,
  kCartesianImpedance = 1,
  kExternalController = 2,
  kOther = 3,
};

/// The modes of a motion.
struct MotionModes {
  ControllerMode controller = ControllerMode::kJointImpedance;
  MotionGeneratorMode generator = MotionGeneratorMode::kJointPosition;
  /// Present in an asynchronous position motion: commands are goals, sent at any time, which INT
  /// approaches with these joint velocities at most, rad/s. FCI protocol 10; joint positions only.
  std::optional<JointVector> asynchronous{};
};

/// Names as clients of the real robot print them ("Idle", "Move", "User stopped", ...).
[[nodiscard]] std::string_view Name(RobotMode mode) noexcept;
/// Names in snake case ("joint_position", ...), as scenarios write them.
[[nodiscard]] std::string_view Name(MotionGeneratorMode mode) noexcept;
/// Names in snake case ("joint_impedance", ...), as scenarios write them.
[[nodiscard]] std::string_view Name(ControllerMode mode) noexcept;

/// "joint_position motion under joint_impedance"; without a generator "torque motion under
/// external".
[[nodiscard]] std::string DescribeMotion(MotionGeneratorMode generator, ControllerMode controller);

/// Manual actions at the robot beside the wire: buttons and switches. Source: FCI protocol 5, user
/// stop, guiding, brakes, recovery.
enum class PanelAction : std::uint8_t {
  kPressUserStop,
  kReleaseUserStop,
  kCloseBrakes,
  kOpenBrakes,
  kPressGuidingButton,
  kReleaseGuidingButton,
};

inline constexpr int kPanelActions = 6;

/// In snake case: "press_user_stop", ...
[[nodiscard]] std::string_view Name(PanelAction action) noexcept;

}  // namespace twin
