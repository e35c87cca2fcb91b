#include "twin/core/robot_errors.h"

#include <fmt/format.h>

#include "twin/core/error_catalogue.h"

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

/// Value and limit: the middle of the sentence.
std::string Compared(const Violation& violation, const ErrorEntry& entry) {
  if (violation.error == RobotError::kCommunicationConstraintsViolation) {
    return violation.axis == kNoFirstCommandAxis
               ? fmt::format("no first command in {:.9g} cycles since the start of the motion",
                             violation.value)
               : fmt::format("{:.9g} cycles in a row without a command; {:.9g} end a motion",
                             violation.value, violation.limit);
  }
  if (violation.error == RobotError::kInstabilityDetected) {
    return violation.axis == kNoNumberAxis
               ? fmt::format("{} was no number", entry.quantity)
               : fmt::format("{} still moved at {:.9g} {}, not below {:.9g} {} as at rest",
                             AxisName(violation), violation.value, UnitOf(violation),
                             violation.limit, UnitOf(violation));
  }
  const std::string axis = AxisName(violation);
  const std::string_view unit = UnitOf(violation);
  return fmt::format("{}{}{} {:.9g}{}{} is beyond the limit {:.9g}", axis, axis.empty() ? "" : ", ",
                     entry.quantity, violation.value, unit.empty() ? "" : " ", unit,
                     violation.limit);
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
  const ErrorEntry& entry = EntryOf(violation);
  const bool is_loss = violation.error == RobotError::kCommunicationConstraintsViolation;
  return fmt::format("{}: {} in the cycle of state {} ({}{}).", Name(violation.error),
                     Compared(violation, entry), violation.message_id,
                     is_loss ? "" : "computed as ", entry.computed);
}

}  // namespace twin
