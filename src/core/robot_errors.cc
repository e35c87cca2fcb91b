#include "twin/core/robot_errors.h"

#include <fmt/format.h>

namespace twin {
namespace {

constexpr std::array<std::string_view, kRobotErrorCount> kNames{
    "joint_position_limits_violation",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "joint_velocity_violation",
    "cartesian_velocity_violation",
    "force_control_safety_violation",
    "joint_reflex",
    "cartesian_reflex",
    "max_goal_pose_deviation_violation",
    "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation",
    "start_elbow_sign_inconsistent",
    "communication_constraints_violation",
    "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame_flag",
    "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning",
    "tau_J_range_violation",
    "instability_detected",
    "joint_move_in_wrong_direction",
    "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation",
    "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading",
};

/// What was compared, its unit, and how it came about: for the errors INT raises today.
struct Quantity {
  std::string_view name;
  std::string_view unit;
  std::string_view computed;
};

Quantity QuantityOf(RobotError error) noexcept {
  switch (error) {
    case RobotError::kJointPositionMotionGeneratorStartPoseInvalid:
      return {"distance of the first command", "rad",
              "|q_c - q_d| at the first command of the motion"};
    case RobotError::kJointMotionGeneratorPositionLimitsViolation:
      return {"position", "rad",
              "the commanded position, or the integral of the commanded velocity"};
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
      return {"velocity", "rad/s", "(q_c - q_d) / 1 ms, or the commanded velocity"};
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
      return {"acceleration", "rad/s^2", "(dq - dq_d) / 1 ms"};
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
      return {"jerk", "rad/s^3", "(ddq - ddq_d) / 1 ms"};
    case RobotError::kControllerTorqueDiscontinuity:
      return {"torque rate", "Nm/s", "(tau_d - tau_J_d) / 1 ms, tau_J_d the last accepted torque"};
    case RobotError::kTauJRangeViolation: return {"measured torque", "Nm", ""};
    default: return {"value", "", ""};
  }
}

}  // namespace

std::string_view Name(RobotError error) noexcept {
  const auto index = static_cast<std::size_t>(error);
  return index < kNames.size() ? kNames[index] : "unknown_error";
}

std::string FormatErrors(const RobotErrors& errors) {
  std::string text = "[";
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if (!errors[i]) continue;
    if (text.size() > 1) text += ", ";
    text += fmt::format("\"{}\"", kNames[i]);
  }
  return text + "]";
}

std::string Describe(const Violation& violation) {
  if (violation.error == RobotError::kCommunicationConstraintsViolation) {
    return fmt::format(
        "{}: {} cycles in a row without a command, at most {} are bridged; ended in the cycle of "
        "state {} (a command counts when it answers the last state and arrives before the "
        "deadline).",
        Name(violation.error), violation.value, violation.limit - 1, violation.message_id);
  }
  const Quantity quantity = QuantityOf(violation.error);
  std::string text{Name(violation.error)};
  text += violation.axis >= 0 ? fmt::format(": joint {}, ", violation.axis + 1) : std::string(": ");
  text += fmt::format("{} {:.9g}", quantity.name, violation.value);
  if (!quantity.unit.empty()) text += fmt::format(" {}", quantity.unit);
  text += fmt::format(" is beyond the limit {:.9g} in the cycle of state {}", violation.limit,
                      violation.message_id);
  if (!quantity.computed.empty()) text += fmt::format(" (computed as {})", quantity.computed);
  return text + ".";
}

}  // namespace twin
