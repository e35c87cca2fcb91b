#include "plugins/mujoco/emulated_backend.h"

#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"

namespace twin::plugins {
namespace {

using onboard::MoveStatus;
using onboard::RecoveryStatus;
using onboard::SetterStatus;

backend::MotionEnd EndOf(MoveStatus status) noexcept {
  switch (status) {
    case MoveStatus::kMotionStarted: return backend::MotionEnd::kNone;
    case MoveStatus::kSuccess: return backend::MotionEnd::kSuccess;
    case MoveStatus::kPreempted: return backend::MotionEnd::kPreempted;
    default: return backend::MotionEnd::kAborted;
  }
}

RobotFault Refused(std::string_view request, RobotMode mode) {
  return RobotFault(
      fmt::format("{} rejected: not possible in the current mode (\"{}\"), or the arm still moves",
                  request, Name(mode)));
}

}  // namespace

backend::Description DescribeRobot(const std::string& plant_name, const robot::LastMotion& last) {
  backend::Description description;
  description.name = "mujoco";
  description.robot = fmt::format("emulated Panda, {}", plant_name);
  description.last_end = EndOf(last.end);
  for (const Violation& violation : last.violations.items()) {
    description.last_errors.set(static_cast<std::size_t>(violation.error));
    description.violations.push_back(violation);
  }
  return description;
}

void RequireStarted(MoveStatus status, const MotionModes& modes, RobotMode mode) {
  switch (status) {
    case MoveStatus::kMotionStarted: return;
    case MoveStatus::kInvalidArgumentRejected:
      throw RobotFault(
          fmt::format("Move rejected: this robot offers no {} motion with the {} controller; "
                      "choose another motion generator or another controller",
                      Name(modes.generator), Name(modes.controller)));
    default: throw Refused("Move", mode);
  }
}

void RequireSet(SetterStatus status, const backend::JointImpedance& impedance, RobotMode mode) {
  switch (status) {
    case SetterStatus::kSuccess: return;
    case SetterStatus::kCommandNotPossibleRejected: throw Refused("Set Joint Impedance", mode);
    case SetterStatus::kInvalidArgumentRejected:
      throw InputError(fmt::format(
          "Set Joint Impedance rejected: K_theta is [{}] Nm/rad; each must lie in [0, {}]",
          fmt::join(impedance.K_theta, ", "), onboard::kMaxJointStiffness));
  }
}

void RequireRecovered(RecoveryStatus status, RobotMode mode) {
  if (status != RecoveryStatus::kSuccess) throw Refused("Automatic Error Recovery", mode);
}

}  // namespace twin::plugins
