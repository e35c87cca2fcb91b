#include "proxy/relay_request_handler.h"

#include <algorithm>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/fci/requests.h"

namespace twin::proxy {
namespace {

constexpr Duration kTimeout = std::chrono::milliseconds(100);
/// Number and size of the robot's pieces relayed before other connections get a turn.
constexpr int kMostPieces = 16;
constexpr std::size_t kPiece = std::size_t{64} << 10;

template <typename Request>
std::optional<fci::Connect> ConnectOf(const std::variant<Request, fci::BadFrame>& parsed) {
  const auto* request = std::get_if<Request>(&parsed);
  const auto* connect = request == nullptr ? nullptr : std::get_if<fci::Connect>(request);
  return connect == nullptr ? std::nullopt : std::optional(*connect);
}

std::optional<fci::Connect> ConnectOf(fci::HeadKind kind, const fci::Frame& frame) {
  return kind == fci::HeadKind::kArm ? ConnectOf(fci::ParseArmRequest(frame))
                                     : ConnectOf(fci::ParseHandRequest(frame));
}

std::vector<std::byte> BytesOf(fci::HeadKind kind, std::uint32_t id, const fci::Connect& connect) {
  return kind == fci::HeadKind::kArm ? fci::EncodeRequest(id, fci::ArmRequest(connect))
                                     : fci::EncodeRequest(id, fci::HandRequest(connect));
}

/// True if an arm's answer is the first of a Move's two. The numbers are the same in all protocols.
bool HasBegun(const fci::Frame& frame) {
  constexpr auto kMove = static_cast<std::uint32_t>(fci::ArmCommand::kMove);
  constexpr auto kStarted = static_cast<std::byte>(MoveStatus::kMotionStarted);
  return frame.head.command == kMove && !frame.payload.empty() && frame.payload[0] == kStarted;
}

}  // namespace

RelayRequestHandler::RelayRequestHandler(const Settings& settings, const MonotonicClock& clock,
                                         const server::TellPeople& tell)
    : settings_(settings), clock_(clock), tell_(tell) {}

void RelayRequestHandler::AddTo(std::vector<pollfd>& waited) const {
  // Do not read from the robot while the client has unsent data.
  if (robot_ && !client_->has_unsent()) waited.push_back({robot_->fd(), POLLIN, 0});
}

Duration RelayRequestHandler::poll_timeout() const {
  return kTimeout;
}

std::optional<std::string> RelayRequestHandler::OnFrame(const fci::Frame& frame) {
  try {
    if (!robot_) Reach();
    ++owed_;
    return Forward(Passed(frame));
  } catch (const EnvironmentError& error) {
    is_broken_ = true;
    return error.what();
  }
}

std::optional<std::string> RelayRequestHandler::Forward(std::span<const std::byte> bytes) {
  std::size_t sent = 0;
  const fci::StreamResult result = robot_->Send(bytes, sent);
  // A closed connection may have left answers: Poll() relays them, then reports the end.
  const bool has_ended =
      result == fci::StreamResult::kReset || result == fci::StreamResult::kClosed;
  if (has_ended || sent == bytes.size()) return {};
  is_broken_ = true;
  return "the robot takes no more requests";
}

void RelayRequestHandler::Reach() {
  robot_ = fci::TcpStream::Connect(settings_.robot, settings_.reach_timeout);
  answers_.emplace(settings_.kind, fci::kLargestModelLibrary);
  tell_(fmt::format("{}: {} connected to {}", settings_.name, fci::ToString(client_->peer()),
                    fci::ToString(settings_.robot)));
}

std::vector<std::byte> RelayRequestHandler::Passed(const fci::Frame& frame) {
  std::optional<fci::Connect> connect = ConnectOf(settings_.kind, frame);
  // Without a UDP port the client gets no datagrams.
  if (!connect || connect->udp_port == 0) return fci::BytesOf(settings_.kind, frame);
  connect->udp_port = Cross(connect->udp_port);
  return BytesOf(settings_.kind, frame.head.command_id, *connect);
}

std::uint16_t RelayRequestHandler::Cross(std::uint16_t client_port) {
  EndRelay();
  const Endpoints endpoints{.client = {client_->peer().address, client_port},
                            .client_side = client_->local().address,
                            .robot = settings_.robot.address,
                            .robot_side = robot_->local().address};
  relay_.emplace(clock_, endpoints, settings_.faults, settings_.thread);
  if (!std::exchange(noticed_, true)) {
    for (const std::string& notice : relay_->notices()) tell_("note: " + notice);
  }
  return relay_->port();
}

std::optional<std::string> RelayRequestHandler::Poll(Time /*now*/) {
  for (int i = 0; robot_ && i < kMostPieces && !client_->has_unsent(); ++i) {
    std::size_t received = 0;
    const std::span<std::byte> room = answers_->Room();
    const std::span<std::byte> piece = room.first(std::min(room.size(), kPiece));
    switch (robot_->Receive(piece, received)) {
      case fci::StreamResult::kDone:
        client_->Send(piece.first(received));
        answers_->Received(received);
        CountAnswers();
        if (answers_->fault() == nullptr) break;
        is_broken_ = true;
        return fmt::format("the robot sends what is no answer ({})", *answers_->fault());
      case fci::StreamResult::kPending: return {};
      case fci::StreamResult::kClosed: return "the robot has closed the connection";
      case fci::StreamResult::kReset: is_broken_ = true; return "the robot's connection broke";
    }
  }
  return {};
}

void RelayRequestHandler::CountAnswers() {
  while (const auto frame = answers_->Next()) {
    const bool has_begun = settings_.kind == fci::HeadKind::kArm && HasBegun(*frame);
    if (!has_begun && owed_ > 0) --owed_;
  }
}

void RelayRequestHandler::EndRelay() {
  if (!relay_) return;
  counts_ += relay_->End();
  relay_.reset();
}

void RelayRequestHandler::OnDisconnect() {
  EndRelay();
  if (robot_) client_->is_broken() ? robot_->ResetConnection() : robot_->Close();
  robot_.reset();
  answers_.reset();
  owed_ = 0;
  client_ = nullptr;
  is_broken_ = false;
}

}  // namespace twin::proxy
