#include "server/hand_request_handler.h"

#include <fmt/format.h>

#include "twin/fci/hand_state_id.h"

namespace twin::server {
namespace {

/// Period of states. The real hand's rate is not public; clients accept any rate above 1 Hz.
constexpr Duration kStatePeriod = std::chrono::milliseconds(10);

}  // namespace

HandRequestHandler::HandRequestHandler(robot::ThreadedRobot& robot, const MonotonicClock& clock,
                                       std::uint32_t address, const TellPeople& tell,
                                       fci::Capture* capture)
    : robot_(robot),
      clock_(clock),
      tell_(tell),
      capture_(capture),
      socket_(clock, {address, 0}),
      device_(robot.hand_device()) {}

void HandRequestHandler::OnConnect(Connection& client) {
  client_ = client.peer();
  connected_ = false;
  last_id_.reset();
  fci::HandService& service = *this;
  session_.emplace(
      service, [&client](std::span<const std::byte> bytes) { client.Send(bytes); }, device_);
}

std::optional<std::string> HandRequestHandler::OnFrame(const fci::Frame& frame) {
  auto why = session_->OnFrame(frame);
  if (!connected_ && session_->udp_port()) {
    connected_ = true;
    tell_(fmt::format("hand: {} connected; states go to its UDP port {}", fci::ToString(client_),
                      *session_->udp_port()));
  }
  return why;
}

std::optional<std::string> HandRequestHandler::Poll(Time now) {
  if (!connected_ || now < next_state_) return {};
  next_state_ = now + kStatePeriod;
  SendState();
  session_->OnProgress();
  return {};
}

Duration HandRequestHandler::poll_timeout() const {
  return kStatePeriod;
}

void HandRequestHandler::SendState() {
  HandState state = robot_.hand_state();
  // The hand's time may stand still, but the client must see rising ids.
  if (last_id_ && !fci::IsNewer(state.message_id, *last_id_)) state.message_id = *last_id_ + 1;
  last_id_ = state.message_id;
  const std::span<const std::byte> datagram = Encoded(state);
  // A datagram that the system does not take is lost, as on the wire.
  const fci::Endpoint to{client_.address, *session_->udp_port()};
  static_cast<void>(socket_.Send(datagram, to));
  if (capture_ == nullptr) return;
  capture_->Put({.at = clock_.Now(),
                 .transport = record::Transport::kUdp,
                 .from = socket_.local(),
                 .to = to,
                 .bytes = datagram});
}

std::span<const std::byte> HandRequestHandler::Encoded(const HandState& state) {
  if (device_ == HandDevice::kFrankaHand) {
    fci::Encode(state, outgoing_);
    return outgoing_;
  }
  VacuumState pump = state.pump.value();
  pump.message_id = state.message_id;
  fci::Encode(pump, outgoing_vacuum_);
  return outgoing_vacuum_;
}

HandStart HandRequestHandler::Start(const HandCommand& command) {
  HandStart start = robot_.StartHand(command);
  if (start.bad) tell_(fmt::format("hand: {} refused: {}", Name(command), Describe(*start.bad)));
  return start;
}

std::optional<HandResult> HandRequestHandler::Outcome(HandTicket ticket) {
  return robot_.HandOutcome(ticket);
}

}  // namespace twin::server
