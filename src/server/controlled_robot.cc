#include "twin/server/controlled_robot.h"

#include <cstddef>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/model/transform.h"

namespace twin::server {
namespace {

constexpr const char* kOnlyBetween = "refused in a motion, and while the hand executes a command";

std::string WhyNot(RecoveryStatus status, RobotMode mode) {
  switch (status) {
    case RecoveryStatus::kManualErrorRecoveryRequiredRejected:
      return "a joint is beyond its limit; lead the arm back (guiding)";
    case RecoveryStatus::kCommandNotPossibleRejected:
      return fmt::format("not possible in mode \"{}\", or the arm still moves", Name(mode));
    default: return "the error persists";
  }
}

}  // namespace

void ControlledRobot::Do(const ControlRequest& request) {
  switch (request.verb) {
    case ControlVerb::kStatus: return;
    case ControlVerb::kPause: return Lockstep("pause").Pause();
    case ControlVerb::kResume: return Lockstep("resume").Resume();
    case ControlVerb::kStep:
      if (Lockstep("step").Step(request.cycles)) return;
      throw InputError("step: time runs, or another step does; pause first");
    case ControlVerb::kUserStop:
      return Operate(request.on ? PanelAction::kPressUserStop : PanelAction::kReleaseUserStop);
    case ControlVerb::kGuiding:
      return Operate(request.on ? PanelAction::kPressGuidingButton
                                : PanelAction::kReleaseGuidingButton);
    case ControlVerb::kReset: return Reset(request.q);
    case ControlVerb::kPlace: return Place(request);
    case ControlVerb::kSnapshot:
      if (Lockstep("snapshot").Save(request.name)) return;
      throw InputError(fmt::format("snapshot: {}", kOnlyBetween));
    case ControlVerb::kRestore:
      if (Lockstep("restore").Restore(request.name)) return;
      throw InputError(fmt::format("restore: {}", kOnlyBetween));
    case ControlVerb::kRecover: {
      const RecoveryStatus status = served_.robot().AutomaticErrorRecovery();
      if (status == RecoveryStatus::kSuccess) return;
      throw InputError(fmt::format("recover: refused: {}", WhyNot(status, served_.robot().mode())));
    }
  }
}

bool ControlledRobot::IsBusy() const {
  const robot::AnswerPacedRobot* const lockstep = served_.lockstep();
  const auto cycles_left = lockstep != nullptr ? lockstep->cycles_left() : std::nullopt;
  return cycles_left ? *cycles_left > 0
                     : served_.robot().mode() == RobotMode::kAutomaticErrorRecovery;
}

std::string ControlledRobot::StatusLine() const {
  const robot::ThreadedRobot& robot = served_.robot();
  const robot::AnswerPacedRobot* const lockstep = served_.lockstep();
  const RobotState state = robot.state();
  nlohmann::ordered_json errors = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if (state.errors[i]) errors.push_back(Name(static_cast<RobotError>(i)));
  }
  return nlohmann::ordered_json{
      {"ok", true},
      {"cycle", state.message_id},
      {"time_s", ToSeconds(static_cast<std::int64_t>(state.message_id) * kCycle)},
      {"mode", Name(robot.mode())},
      {"paused", lockstep != nullptr && lockstep->cycles_left().has_value()},
      {"lockstep", lockstep != nullptr},
      {"errors", errors},
      {"q", state.q}}
      .dump();
}

robot::AnswerPacedRobot& ControlledRobot::Lockstep(std::string_view what) const {
  if (!has_own_time_) {
    throw InputError(
        fmt::format("{}: several robots have one time, which stands still for none of them", what));
  }
  robot::AnswerPacedRobot* const lockstep = served_.lockstep();
  if (lockstep != nullptr) return *lockstep;
  throw InputError(fmt::format(
      "{}: this robot runs on the wall clock, which never stands still; serve it in lockstep, as "
      "with --drive lockstep or --pace 1",
      what));
}

void ControlledRobot::Reset(const std::optional<JointVector>& q) {
  robot::AnswerPacedRobot& robot = Lockstep("reset");
  if (!may_reset_) {
    throw InputError(
        "reset: this robot is served with --reset never, the default; serve it with --reset "
        "on-command");
  }
  if (q) served_.RequireFree(*q);
  if (robot.Reset(q)) return;
  throw InputError(fmt::format("reset: {}", kOnlyBetween));
}

void ControlledRobot::Place(const ControlRequest& request) {
  const auto about = [&](std::size_t i, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(request.rpy[i], axis);
  };
  const Eigen::Quaterniond turn = about(2, Eigen::Vector3d::UnitZ()) *
                                  about(1, Eigen::Vector3d::UnitY()) *
                                  about(0, Eigen::Vector3d::UnitX());
  served_.Place(request.name, model::Pose(turn, Eigen::Vector3d(request.position.data())));
}

void ControlledRobot::Operate(PanelAction action) {
  robot::ThreadedRobot& robot = served_.robot();
  if (robot.Operate(action)) return;
  throw InputError(fmt::format("{}: the robot does not accept it in mode \"{}\"", Name(action),
                               Name(robot.mode())));
}

}  // namespace twin::server
