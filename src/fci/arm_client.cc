#include "twin/fci/arm_client.h"

#include <utility>
#include <variant>

#include <fmt/format.h>

#include "fci/request_channel.h"
#include "twin/core/error.h"

namespace twin::fci {
namespace {

/// Datagrams per Receive(): more than the kernel queues by default.
constexpr int kMostAtOnce = 64;

/// How far a state's id may be ahead of the last one: a constant, plus a rate per ms. The margin
/// exceeds any error of the robot's clock and any delay of the wire.
constexpr std::uint64_t kMostAhead = 1000;
constexpr std::uint64_t kMostAheadPerMs = 2;

/// Largest answer: GetCartesianLimit's, or the URDF. Model libraries are never requested: this
/// program has its own model and runs no code from a robot.
constexpr std::size_t LargestAnswer(Protocol protocol) noexcept {
  return protocol == Protocol::k5 ? 166 : std::size_t{1} << 20;
}

/// What to do with a robot of another version than the scenario's.
std::string_view CureOf(std::uint16_t theirs) noexcept {
  if (theirs == VersionOf(Protocol::k10)) return "it is an FR3: say robot: {model: fr3}";
  if (theirs == VersionOf(Protocol::k5)) return "it is a Panda: say robot: {model: panda}";
  return theirs < VersionOf(Protocol::k5) ? "update the robot to system 4.2.1 or later"
                                          : "update the robot to a system for libfranka 0.18";
}

std::string NameOf(const Endpoint& robot) {
  return fmt::format("the robot {}", ToString(robot));
}

}  // namespace

/// An answer, with the bytes to which it refers.
struct ArmClient::Asked {
  std::uint32_t id = 0;
  RequestChannel::Answer bytes;
  ArmAnswer answer;
};

ArmClient::ArmClient(const MonotonicClock& clock, const std::string& host, std::uint16_t port,
                     const ClientTimeout& timeout, Capture* capture, Protocol protocol)
    : clock_(clock),
      timeout_(timeout),
      protocol_(protocol),
      silence_(timeout.state),
      capture_(capture),
      robot_(Resolve(host, port)) {
  TcpStream stream = TcpStream::Connect(robot_, timeout.connect);
  // States go to the address of this connection, so listen only there.
  udp_ = std::make_unique<UdpSocket>(clock, Endpoint{stream.local().address, 0});
  channel_ = std::make_unique<RequestChannel>(HeadKind::kArm, std::move(stream), NameOf(robot_),
                                              LargestAnswer(protocol), timeout.answer, capture);
  Negotiate();
}

ArmClient::~ArmClient() = default;

void ArmClient::Negotiate() {
  const std::uint16_t ours = VersionOf(protocol_);
  const Connect request{ours, udp_->local().port};
  const ArmAnswer answer = Ask(request, timeout_.connect).answer;
  version_ = answer.version;
  if (answer.status == static_cast<std::uint8_t>(ConnectStatus::kSuccess)) return;
  if (answer.status != static_cast<std::uint8_t>(ConnectStatus::kIncompatibleLibraryVersion)) {
    throw RobotFault(fmt::format("Connect: {} refuses with the unknown status {}; is it an arm?",
                                 NameOf(robot_), answer.status));
  }
  throw RobotFault(fmt::format(
      "Connect: {} speaks version {} of the Franka Control Interface, this program version {} with "
      "the robot of the scenario; {}",
      NameOf(robot_), answer.version, ours, CureOf(answer.version)));
}

ArmClient::Asked ArmClient::Ask(const ArmRequest& request, Duration timeout) {
  const ArmCommand command = CommandOf(request);
  const std::string_view name = Name(command);
  if (!NumberOf(protocol_, command)) {
    throw RobotFault(
        fmt::format("{}: protocol {} has no such request", name, VersionOf(protocol_)));
  }
  Asked asked;
  asked.id =
      channel_->Send(name, [&](std::uint32_t id) { return EncodeRequest(id, request, protocol_); });
  auto bytes = channel_->Await(asked.id, name, timeout);
  // An accepted Move has a second answer.
  if (command != ArmCommand::kMove) channel_->Forget(asked.id);
  if (!bytes) {
    channel_->Forget(asked.id);
    throw RobotFault(fmt::format("{}: {} has not answered for {} s; see whether it still runs",
                                 name, NameOf(robot_), ToSeconds(timeout)));
  }
  asked.bytes = std::move(*bytes);
  const auto answer = ParseArmAnswer(command, asked.bytes.frame(), protocol_);
  if (const auto* bad = std::get_if<BadFrame>(&answer)) {
    channel_->Forget(asked.id);
    throw RobotFault(
        fmt::format("{}: {} sends an answer that is none: {}", name, NameOf(robot_), bad->what));
  }
  asked.answer = std::get<ArmAnswer>(answer);
  return asked;
}

std::uint8_t ArmClient::AskForStatus(const ArmRequest& request, std::uint8_t last) {
  const std::uint8_t status = Ask(request, timeout_.answer).answer.status;
  if (status <= last) return status;
  throw RobotFault(fmt::format("{}: {} answers with status {}; the protocol knows 0 to {}",
                               Name(CommandOf(request)), NameOf(robot_), status, last));
}

MoveStatus ArmClient::Move(const fci::Move& move) {
  const Asked asked = Ask(move, timeout_.answer);
  const auto status = static_cast<MoveStatus>(asked.answer.status);
  if (status != MoveStatus::kMotionStarted) {
    channel_->Forget(asked.id);
    return status;
  }
  const std::lock_guard lock(motion_);
  if (move_id_) channel_->Forget(*move_id_);
  move_id_ = asked.id;
  last_move_end_.reset();
  return status;
}

std::optional<MoveStatus> ArmClient::AwaitMotionEnd(Duration timeout) noexcept {
  const std::lock_guard lock(motion_);
  if (!move_id_) return last_move_end_;
  try {
    const auto bytes = channel_->Await(*move_id_, Name(ArmCommand::kMove), timeout);
    if (!bytes) return std::nullopt;
    const auto answer = ParseArmAnswer(ArmCommand::kMove, bytes->frame(), protocol_);
    const auto* read = std::get_if<ArmAnswer>(&answer);
    // Any other answer still means that the motion has ended.
    last_move_end_ = read == nullptr ? MoveStatus::kAborted : static_cast<MoveStatus>(read->status);
  } catch (const std::exception&) {
    return std::nullopt;  // the connection is lost; Receive() reports it
  }
  channel_->Forget(*move_id_);
  move_id_.reset();
  return last_move_end_;
}

StopStatus ArmClient::StopMove() {
  return static_cast<StopStatus>(
      AskForStatus(fci::StopMove{}, static_cast<std::uint8_t>(StopStatus::kAborted)));
}

SetterStatus ArmClient::Configure(const Setting& setting) {
  return static_cast<SetterStatus>(
      AskForStatus(setting, static_cast<std::uint8_t>(SetterStatus::kInvalidArgumentRejected)));
}

SetterStatus ArmClient::CartesianLimitOf(std::int32_t id, CartesianLimit& limit) {
  const ArmAnswer answer = Ask(GetCartesianLimit{id}, timeout_.answer).answer;
  const auto status = static_cast<SetterStatus>(answer.status);
  if (status == SetterStatus::kSuccess) limit = answer.limit;
  return status;
}

RecoveryStatus ArmClient::Recover() {
  return static_cast<RecoveryStatus>(
      AskForStatus(AutomaticErrorRecovery{}, static_cast<std::uint8_t>(RecoveryStatus::kAborted)));
}

TwinKind ArmClient::AskForTwin() {
  try {
    if (protocol_ == Protocol::k10) {
      const Asked asked = Ask(GetRobotModel{}, timeout_.connect);
      const std::span<const std::byte> urdf = asked.answer.library;
      // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): text in received bytes.
      return TwinKindOf({reinterpret_cast<const char*>(urdf.data()), urdf.size()});
    }
    const ArmAnswer answer = Ask(GetCartesianLimit{kTwinSign}, timeout_.connect).answer;
    const bool is_wall = answer.status == static_cast<std::uint8_t>(SetterStatus::kSuccess);
    return is_wall ? TwinKindOf(answer.limit) : TwinKind::kNone;
  } catch (const RobotFault&) {
    if (lost()) throw;
    return TwinKind::kNone;  // a refusal may be shorter than a wall's answer
  }
}

ReceiveResult ArmClient::Receive(RobotState& state, Time& at) noexcept {
  if (channel_->lost() || has_ended()) return ReceiveResult::kLost;
  bool found = false;
  for (int i = 0; i < kMostAtOnce; ++i) {
    const std::optional<Datagram> datagram = udp_->Receive(state_bytes_);
    if (!datagram) {
      found_empty_ = own_clock_.Now();
      break;
    }
    if (capture_ != nullptr) {
      Keep(capture_->TimeOf(clock_, datagram->at), datagram->from, udp_->local(), datagram->bytes);
    }
    if (!Accept(*datagram)) continue;
    state = received_;
    found = true;
  }
  if (has_ended()) return ReceiveResult::kLost;
  if (!found) return FoundNone();
  pending_since_.reset();
  at = clock_.Now();
  return ReceiveResult::kState;
}

bool ArmClient::Accept(const Datagram& datagram) noexcept {
  if (!IsFromRobot(datagram.from)) {
    foreign_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (Decode(protocol_, datagram.bytes, received_) != DatagramFault::kNone) {
    bad_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (has_state_ && received_.message_id <= last_id_) {
    old_.fetch_add(1, std::memory_order_relaxed);
    if (answers_again_ && received_.message_id == last_id_) SendAgain();
    return false;
  }
  if (has_state_ && received_.message_id - last_id_ > MostAhead()) {
    ahead_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (const std::string_view field = FieldWithoutNumber(received_); !field.empty()) {
    no_number_.store(field.data(), std::memory_order_relaxed);
    return false;
  }
  if (!has_state_) udp_->ListenOnlyTo(datagram.from);
  has_state_ = true;
  last_id_ = received_.message_id;
  to_ = datagram.from;
  sent_after_ = found_empty_;
  before_ = counts();
  return true;
}

bool ArmClient::IsFromRobot(const Endpoint& from) const noexcept {
  return has_state_ ? from == to_ : from.address == robot_.address;
}

std::uint64_t ArmClient::MostAhead() const noexcept {
  const Duration since = own_clock_.Now() - sent_after_;
  return kMostAhead + kMostAheadPerMs * static_cast<std::uint64_t>(since / kCycle);
}

ReceiveResult ArmClient::FoundNone() noexcept {
  const Time now = clock_.Now();
  // The clock may have been restarted.
  if (!pending_since_ || *pending_since_ > now) pending_since_ = now;
  if (now - *pending_since_ <= silence_) return ReceiveResult::kPending;
  const RejectedDatagrams now_found = counts();
  instead_ = {now_found.old - before_.old, now_found.ahead - before_.ahead,
              now_found.foreign - before_.foreign, now_found.bad - before_.bad};
  silent_.store(true, std::memory_order_release);
  return ReceiveResult::kLost;
}

void ArmClient::Send(const RobotCommand& command) noexcept {
  if (!has_state_) return;
  static_cast<void>(Encode(protocol_, command, command_bytes_));
  answered_id_ = command.message_id;
  SendBytes();
}

void ArmClient::SendAgain() noexcept {
  if (answered_id_ == last_id_) SendBytes();
}

void ArmClient::SendBytes() noexcept {
  const auto bytes = std::span(std::as_const(command_bytes_)).first(CommandBytesOf(protocol_));
  if (capture_ != nullptr) Keep(capture_->clock().Now(), udp_->local(), to_, bytes);
  static_cast<void>(udp_->Send(bytes, to_));
}

void ArmClient::Keep(Time at, const Endpoint& from, const Endpoint& to,
                     std::span<const std::byte> bytes) noexcept {
  capture_->PutRealtime(
      {.at = at, .transport = record::Transport::kUdp, .from = from, .to = to, .bytes = bytes});
}

bool ArmClient::lost() const noexcept {
  return channel_->lost();
}

std::string ArmClient::WhyLost() const {
  if (channel_->lost()) return channel_->WhyLost();
  if (const char* const field = no_number_.load(std::memory_order_relaxed)) {
    return fmt::format(
        "{} sends states that hold no numbers: NaN or infinity in {}; no measurement is right any "
        "more, restart the robot",
        NameOf(robot_), field);
  }
  if (!silent_.load(std::memory_order_acquire)) return {};
  const std::string silence =
      fmt::format("no state of {} has come for {} s", NameOf(robot_), ToSeconds(silence_));
  if (instead_ == RejectedDatagrams()) return silence + "; does a firewall stop UDP?";
  return fmt::format(
      "{}; what came instead: {} datagrams from elsewhere, {} that are no states, {} no newer than "
      "one that had come, {} too far ahead of it; does another program send in the robot's name?",
      silence, instead_.foreign, instead_.bad, instead_.old, instead_.ahead);
}

RejectedDatagrams ArmClient::counts() const noexcept {
  return {old_.load(std::memory_order_relaxed), ahead_.load(std::memory_order_relaxed),
          foreign_.load(std::memory_order_relaxed), bad_.load(std::memory_order_relaxed)};
}

}  // namespace twin::fci
