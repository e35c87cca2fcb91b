#include "twin/core/modes.h"

#include <fmt/format.h>

namespace twin {

std::string_view Name(RobotMode mode) noexcept {
  switch (mode) {
    case RobotMode::kOther: return "Other";
    case RobotMode::kIdle: return "Idle";
    case RobotMode::kMove: return "Move";
    case RobotMode::kGuiding: return "Guiding";
    case RobotMode::kReflex: return "Reflex";
    case RobotMode::kUserStopped: return "User stopped";
    case RobotMode::kAutomaticErrorRecovery: return "Automatic error recovery";
  }
  return "unknown";
}

std::string_view Name(MotionGeneratorMode mode) noexcept {
  switch (mode) {
    case MotionGeneratorMode::kIdle: return "idle";
    case MotionGeneratorMode::kJointPosition: return "joint_position";
    case MotionGeneratorMode::kJointVelocity: return "joint_velocity";
    case MotionGeneratorMode::kCartesianPosition: return "cartesian_position";
    case MotionGeneratorMode::kCartesianVelocity: return "cartesian_velocity";
    case MotionGeneratorMode::kNone: return "none";
  }
  return "unknown";
}

std::string_view Name(ControllerMode mode) noexcept {
  switch (mode) {
    case ControllerMode::kJointImpedance: return "joint_impedance";
    case ControllerMode::kCartesianImpedance: return "cartesian_impedance";
    case ControllerMode::kExternalController: return "external";
    case ControllerMode::kOther: return "other";
  }
  return "unknown";
}

std::string DescribeMotion(MotionGeneratorMode generator, ControllerMode controller) {
  const bool is_torque = generator == MotionGeneratorMode::kNone;
  return fmt::format("{} motion under {}", is_torque ? "torque" : Name(generator),
                     Name(controller));
}

std::string_view Name(PanelAction action) noexcept {
  switch (action) {
    case PanelAction::kPressUserStop: return "press_user_stop";
    case PanelAction::kReleaseUserStop: return "release_user_stop";
    case PanelAction::kCloseBrakes: return "close_brakes";
    case PanelAction::kOpenBrakes: return "open_brakes";
    case PanelAction::kPressGuidingButton: return "press_guiding_button";
    case PanelAction::kReleaseGuidingButton: return "release_guiding_button";
  }
  return "unknown";
}

}  // namespace twin
