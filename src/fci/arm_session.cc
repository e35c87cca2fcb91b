#include "twin/fci/arm_session.h"

#include <utility>
#include <variant>

#include <fmt/format.h>

namespace twin::fci {
namespace {

/// Status of a finished recovery, from the mode in which it ended.
RecoveryStatus RecoveryEnd(RobotMode mode) noexcept {
  switch (mode) {
    case RobotMode::kUserStopped: return RecoveryStatus::kEmergencyAborted;
    case RobotMode::kReflex: return RecoveryStatus::kReflexAborted;
    default: return RecoveryStatus::kSuccess;
  }
}

}  // namespace

ArmSession::ArmSession(ArmService& service, Answers answers, Protocol protocol)
    : service_(service), answers_(std::move(answers)), protocol_(protocol) {}

template <typename Status>
void ArmSession::Answer(ArmCommand command, std::uint32_t command_id, Status status) {
  answers_(EncodeArmAnswer(command, command_id, static_cast<std::uint8_t>(status), protocol_));
}

template <typename Status>
ArmSession::Outcome ArmSession::Answer(Status status) {
  Answer(asked_, head_.command_id, status);
  return {};
}

std::optional<std::string> ArmSession::OnFrame(const Frame& frame) {
  head_ = frame.head;
  const std::variant<ArmRequest, BadFrame> parsed = ParseArmRequest(frame, protocol_);
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) return bad->what;
  const auto& request = std::get<ArmRequest>(parsed);
  asked_ = CommandOf(request);
  const bool connects = std::holds_alternative<Connect>(request);
  if (connects && udp_port_) return "a second Connect";
  if (!connects && !udp_port_) {
    return fmt::format("{} before Connect", Name(asked_));
  }
  return std::visit([this](const auto& one) { return Take(one); }, request);
}

ArmSession::Outcome ArmSession::Take(const Connect& connect) {
  const std::uint16_t version = VersionOf(protocol_);
  const bool fits = connect.version == version;
  const auto status = fits ? ConnectStatus::kSuccess : ConnectStatus::kIncompatibleLibraryVersion;
  if (fits && connect.udp_port == 0) return "Connect without a UDP port for states";
  answers_(EncodeArmConnectAnswer(head_.command_id, status, version));
  if (!fits) {
    return fmt::format("it speaks protocol {}; this robot speaks {}", connect.version, version);
  }
  udp_port_ = connect.udp_port;
  return {};
}

ArmSession::Outcome ArmSession::Take(const Move& move) {
  if (move_) OnProgress(service_.Progress());  // the motion may have ended by now
  const MoveStatus status = service_.Move(move);
  if (status == MoveStatus::kMotionStarted) move_ = head_.command_id;
  return Answer(status);
}

ArmSession::Outcome ArmSession::Take(const StopMove& /*stop*/) {
  if (!move_) return Answer(StopStatus::kSuccess);
  if (stops_.size() >= kMostStops) {
    return fmt::format("{} requests to stop wait for an answer; no more are taken", stops_.size());
  }
  service_.StopMove();
  stops_.push_back(head_.command_id);
  return {};
}

ArmSession::Outcome ArmSession::Take(const GetCartesianLimit& request) {
  CartesianLimit limit;
  const SetterStatus status = service_.CartesianLimitOf(request.id, limit);
  answers_(EncodeCartesianLimitAnswer(head_.command_id, status, limit));
  return {};
}

ArmSession::Outcome ArmSession::Take(const Setting& setting) {
  return Answer(service_.Configure(setting));
}

ArmSession::Outcome ArmSession::Take(const AutomaticErrorRecovery& /*request*/) {
  if (recovery_) return Answer(service_.Recover());
  recovery_ = Recovery{head_.command_id};
  TryRecovery();
  return {};
}

void ArmSession::TryRecovery() {
  const RecoveryStatus status = service_.Recover();
  const RobotMode mode = service_.Progress().mode;
  recovery_->begun =
      status == RecoveryStatus::kSuccess && mode == RobotMode::kAutomaticErrorRecovery;
  const bool comes_to_rest =
      status == RecoveryStatus::kCommandNotPossibleRejected && mode == RobotMode::kReflex;
  if (!recovery_->begun && !comes_to_rest) AnswerRecovery(status);
}

void ArmSession::AnswerRecovery(RecoveryStatus status) {
  Answer(ArmCommand::kAutomaticErrorRecovery, std::exchange(recovery_, {})->command_id, status);
}

ArmSession::Outcome ArmSession::Take(const LoadModelLibrary& machine) {
  const std::span<const std::byte> library = service_.ModelLibrary(machine);
  const auto status = library.empty() ? ModelLibraryStatus::kError : ModelLibraryStatus::kSuccess;
  answers_(EncodeModelLibraryAnswer(head_.command_id, status, library));
  return {};
}

ArmSession::Outcome ArmSession::Take(const GetRobotModel& /*request*/) {
  answers_(EncodeRobotModelAnswer(head_.command_id, service_.RobotModel()));
  return {};
}

void ArmSession::OnProgress(const ArmProgress& progress) {
  if (move_ && !progress.in_motion && progress.last_end != MoveStatus::kMotionStarted) {
    for (const std::uint32_t stop : std::exchange(stops_, {})) {
      Answer(ArmCommand::kStopMove, stop, StopStatus::kSuccess);
    }
    Answer(ArmCommand::kMove, *std::exchange(move_, {}), progress.last_end);
  }
  if (!recovery_) return;
  if (!recovery_->begun && progress.mode == RobotMode::kReflex) {
    TryRecovery();
  } else if (progress.mode != RobotMode::kAutomaticErrorRecovery) {
    AnswerRecovery(RecoveryEnd(progress.mode));
  }
}

void ArmSession::OnClosed() {
  if (move_) service_.StopMove();
  move_.reset();
  stops_.clear();
  recovery_.reset();
  udp_port_.reset();
}

bool ArmSession::has_pending() const noexcept {
  return move_.has_value() || recovery_.has_value();
}

}  // namespace twin::fci
