#include "server/arm_request_handler.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/robot_errors.h"
#include "twin/fci/twin_sign.h"

namespace twin::server {
namespace {

constexpr Duration kTimeout = std::chrono::milliseconds(100);

bool IsAllowance(const fci::Deviation& deviation) noexcept {
  const auto allows = [](double most) { return std::isfinite(most) && most >= 0; };
  return allows(deviation.translation) && allows(deviation.rotation) && allows(deviation.elbow);
}

std::string_view EndText(MoveStatus end) noexcept {
  switch (end) {
    case MoveStatus::kSuccess: return "finished";
    case MoveStatus::kReflexAborted: return "aborted by reflex";
    case MoveStatus::kEmergencyAborted: return "aborted by the user stop";
    default: return "stopped";
  }
}

}  // namespace

ArmRequestHandler::ArmRequestHandler(robot::ThreadedRobot& robot, UdpPort& port,
                                     const ServerConfig& config, const TellPeople& tell)
    : robot_(robot),
      port_(port),
      config_(config),
      robot_model_(config.robot_model + std::string(robot.is_answer_paced() ? fci::kLockstepComment
                                                                            : fci::kTwinComment)),
      tell_(tell) {}

void ArmRequestHandler::OnRobotChanged() {
  static_cast<void>(Progress());
}

bool ArmRequestHandler::IsReady() {
  return !in_motion_ || !Progress().in_motion;
}

void ArmRequestHandler::OnConnect(Connection& client) {
  if (config_.on_arm_client) config_.on_arm_client();
  client_ = client.peer();
  dropped_before_ = port_.dropped();
  fci::ArmService& service = *this;
  session_.emplace(
      service, [&client](std::span<const std::byte> bytes) { client.Send(bytes); },
      config_.protocol);
}

std::optional<std::string> ArmRequestHandler::OnFrame(const fci::Frame& frame) {
  auto why = session_->OnFrame(frame);
  if (!connected_ && session_->udp_port()) {
    connected_ = true;
    port_.OnConnect({client_.address, *session_->udp_port()});
    tell_(fmt::format("arm: {} connected; states go to its UDP port {}", fci::ToString(client_),
                      *session_->udp_port()));
  }
  return why;
}

std::optional<std::string> ArmRequestHandler::Poll(Time /*now*/) {
  if (session_->has_pending()) session_->OnProgress(Progress());
  return {};
}

bool ArmRequestHandler::has_pending() const {
  return session_->has_pending();
}

Duration ArmRequestHandler::poll_timeout() const {
  return kTimeout;
}

void ArmRequestHandler::OnDisconnect() {
  port_.Close();
  connected_ = false;
  TellDropped();
  std::optional<fci::ArmSession> session = std::move(session_);
  session_.reset();
  session->OnClosed();
}

MoveStatus ArmRequestHandler::Move(const fci::Move& move) {
  if (!IsAllowance(move.maximum_path_deviation) || !IsAllowance(move.maximum_goal_pose_deviation)) {
    TellRefused("Move", "a maximum deviation is negative or not finite");
    return MoveStatus::kInvalidArgumentRejected;
  }
  MotionModes modes = move.modes;
  if (move.asynchronous) modes.asynchronous = move.maximum_velocity;
  const MoveStatus status = robot_.Move(modes);
  switch (status) {
    case MoveStatus::kMotionStarted:
      in_motion_ = true;
      stop_asked_ = false;
      tell_("arm: motion started: " + DescribeMotion(move.modes.generator, move.modes.controller));
      break;
    case MoveStatus::kInvalidArgumentRejected:
      TellRefused("Move", move.asynchronous
                              ? "an asynchronous motion is one of joint positions without an "
                                "external controller, with velocities above 0"
                              : "there is no such motion generator or controller");
      break;
    case MoveStatus::kStartAtSingularPoseRejected:
      TellRefused("Move", "cannot start at singular pose");
      break;
    default: TellRefused("Move", NotPossible());
  }
  return status;
}

void ArmRequestHandler::StopMove() {
  stop_asked_ = true;
  robot_.StopMove();
}

SetterStatus ArmRequestHandler::Configure(const Setting& setting) {
  const SetterStatus status = robot_.Configure(setting);
  if (status == SetterStatus::kInvalidArgumentRejected) {
    const std::optional<BadValue> bad = FindBadValue(setting);
    TellRefused(Name(setting), bad ? Describe(*bad) : "a value is out of range");
  } else if (status != SetterStatus::kSuccess) {
    TellRefused(Name(setting), NotPossible());
  }
  return status;
}

RecoveryStatus ArmRequestHandler::Recover() {
  const RecoveryStatus status = robot_.AutomaticErrorRecovery();
  if (status == RecoveryStatus::kManualErrorRecoveryRequiredRejected) {
    TellRefused("Automatic Error Recovery", "a joint is beyond its limit; it must be led back");
  } else if (status != RecoveryStatus::kSuccess && robot_.mode() != RobotMode::kReflex) {
    TellRefused("Automatic Error Recovery",
                NotPossible());  // in Reflex the session waits until the arm is at rest
  }
  return status;
}

SetterStatus ArmRequestHandler::CartesianLimitOf(std::int32_t id, fci::CartesianLimit& limit) {
  const fci::TwinKind kind =
      robot_.is_answer_paced() ? fci::TwinKind::kInLockstep : fci::TwinKind::kOnClock;
  limit = id == fci::kTwinSign ? fci::TwinSign(kind) : fci::CartesianLimit();
  return SetterStatus::kSuccess;
}

std::span<const std::byte> ArmRequestHandler::ModelLibrary(const fci::LoadModelLibrary& machine) {
  const bool is_ours = machine.architecture == fci::Architecture::kX64 &&
                       machine.system == fci::OperatingSystem::kLinux;
  if (is_ours && !config_.model_library.empty()) return config_.model_library;
  TellRefused("Load Model Library",
              is_ours ? "no library was found" : "there is none but for x64 Linux");
  return {};
}

fci::ArmProgress ArmRequestHandler::Progress() {
  const robot::RobotReport report = robot_.report();
  const bool moves = report.mode == RobotMode::kMove;
  if (in_motion_ && !moves) {
    in_motion_ = false;
    TellEnd(report.last_motion);
  }
  if (!in_motion_) TellFound(report.found);
  return {report.mode, moves, report.last_motion.end};
}

void ArmRequestHandler::TellEnd(const robot::LastMotion& motion) {
  std::string text = fmt::format("arm: motion {}", EndText(motion.end));
  if (!motion.violations.empty()) text += ':';
  for (const Violation& violation : motion.violations.items()) {
    text += ' ' + Describe(violation);
    told_ = violation.message_id;
  }
  if (motion.breach) text += " Guard: " + onboard::Describe(robot_.guard(), *motion.breach);
  if (motion.end == MoveStatus::kPreempted && !stop_asked_) {
    text += ": it was not answered for too long (see --session-timeout)";
  }
  tell_(text);
}

void ArmRequestHandler::TellFound(const onboard::Violations& found) {
  const std::uint64_t cycle = found.empty() ? 0 : found.items().front().message_id;
  if (cycle == told_) return;
  told_ = cycle;
  for (const Violation& violation : found.items()) {
    tell_(fmt::format("arm: error without a motion: {}", Describe(violation)));
  }
}

void ArmRequestHandler::TellRefused(std::string_view request, std::string_view why) {
  tell_(fmt::format("arm: {} refused: {}", request, why));
}

std::string ArmRequestHandler::NotPossible() {
  return fmt::format("not possible in the current mode (\"{}\"), or the arm still moves",
                     Name(robot_.mode()));
}

void ArmRequestHandler::TellDropped() {
  const DroppedDatagrams now = port_.dropped();
  const DroppedDatagrams& before = dropped_before_;
  if (now == before) return;
  tell_(fmt::format(
      "arm: datagrams ignored: {} of others or for want of room, {} malformed, {} that answer no "
      "state",
      now.foreign - before.foreign, now.malformed - before.malformed, now.early - before.early));
}

}  // namespace twin::server
