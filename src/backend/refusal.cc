#include "twin/backend/refusal.h"

#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::backend {
namespace {

/// The user's cure for a refusal in this mode.
std::string_view WayOutOf(RobotMode mode) noexcept {
  switch (mode) {
    case RobotMode::kOther: return "open the brakes";
    case RobotMode::kIdle: return "wait until the arm rests";
    case RobotMode::kMove: return "end the motion first";
    case RobotMode::kGuiding: return "let go of the guiding button";
    case RobotMode::kReflex: return "wait until the arm rests, then recover";
    case RobotMode::kUserStopped: return "release the user stop";
    case RobotMode::kAutomaticErrorRecovery: return "wait until the recovery is over";
  }
  return "see what the robot does";
}

RobotFault Refused(std::string_view request, RobotMode mode) {
  return RobotFault(
      fmt::format("{} rejected: not possible in the current mode (\"{}\"), or the arm still moves; "
                  "{}",
                  request, Name(mode), WayOutOf(mode)));
}

}  // namespace

MotionEnd EndOf(MoveStatus status) noexcept {
  switch (status) {
    case MoveStatus::kMotionStarted: return MotionEnd::kNone;
    case MoveStatus::kSuccess: return MotionEnd::kSuccess;
    case MoveStatus::kPreempted: return MotionEnd::kPreempted;
    case MoveStatus::kEmergencyAborted: return MotionEnd::kUserStopped;
    default: return MotionEnd::kAborted;
  }
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
  switch (status) {
    case RecoveryStatus::kSuccess: return;
    case RecoveryStatus::kManualErrorRecoveryRequiredRejected:
      throw RobotFault(
          "Automatic Error Recovery rejected: manual error recovery required; a joint is beyond "
          "its limit: guide the arm back, then recover");
    case RecoveryStatus::kEmergencyAborted:
      throw RobotFault(
          "Automatic Error Recovery aborted: user stop pressed; release it, then recover");
    case RecoveryStatus::kReflexAborted:
    case RecoveryStatus::kAborted:
      throw RobotFault(
          "Automatic Error Recovery aborted by another error; see the current errors, remove "
          "their cause, then recover again");
    case RecoveryStatus::kCommandNotPossibleRejected: break;
  }
  throw Refused("Automatic Error Recovery", mode);
}

void RequireOperated(bool done, PanelAction action, RobotMode mode) {
  if (!done) throw Refused(Name(action), mode);
}

void RequireStarted(const HandStart& start, const HandCommand& command) {
  if (!start.bad) return;
  throw InputError(fmt::format("{} rejected: {}", Name(command), Describe(*start.bad)));
}

}  // namespace twin::backend
