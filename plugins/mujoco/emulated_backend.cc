#include "plugins/mujoco/emulated_backend.h"

#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::plugins {
namespace {

using RecoveryStatus;
using SetterStatus;

backend::MotionEnd EndOf(MoveStatus status) noexcept {
  switch (status) {
    case MoveStatus::kMotionStarted: return backend::MotionEnd::kNone;
    case MoveStatus::kSuccess: return backend::MotionEnd::kSuccess;
    case MoveStatus::kPreempted: return backend::MotionEnd::kPreempted;
    case MoveStatus::kEmergencyAborted: return backend::MotionEnd::kUserStopped;
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
    case MoveStatus::kStartAtSingularPoseRejected:
      throw RobotFault(
          "Move rejected: cannot start at singular pose; move the arm away from it with a joint "
          "motion first");
    default: throw Refused("Move", mode);
  }
}

void RequireSet(SetterStatus status, const Setting& setting, RobotMode mode) {
  if (status == SetterStatus::kSuccess) return;
  if (status == SetterStatus::kCommandNotPossibleRejected) throw Refused(Name(setting), mode);
  const std::optional<BadValue> bad = FindBadValue(setting);
  throw InputError(fmt::format("{} rejected: invalid argument: {}", Name(setting),
                               bad ? Describe(*bad) : "a value is out of range"));
}

void RequireRecovered(RecoveryStatus status, RobotMode mode) {
  if (status == RecoveryStatus::kManualErrorRecoveryRequiredRejected) {
    throw RobotFault(
        "Automatic Error Recovery rejected: manual error recovery required; a joint is beyond its "
        "limit: guide the arm back, then recover");
  }
  if (status != RecoveryStatus::kSuccess) throw Refused("Automatic Error Recovery", mode);
}

void RequireOperated(bool done, PanelAction action, RobotMode mode) {
  if (!done) throw Refused(Name(action), mode);
}

}  // namespace twin::plugins
