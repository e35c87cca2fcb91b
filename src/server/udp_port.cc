#include "twin/server/udp_port.h"

namespace twin::server {
namespace {

/// Datagrams per call: a cycle has one; bounds the time that a flood can cost.
constexpr int kMostAtOnce = 64;

constexpr std::uint64_t Packed(const fci::Endpoint& endpoint) noexcept {
  return std::uint64_t{endpoint.address} << 16 | endpoint.port;
}

void CountOne(std::atomic<std::uint64_t>& count) noexcept {
  count.fetch_add(1, std::memory_order_relaxed);  // a counter; publishes no other data
}

}  // namespace

UdpPort::UdpPort(const MonotonicClock& clock, std::uint32_t address, WakeEvent& changed,
                 fci::Protocol protocol)
    : clock_(clock), socket_(clock, {address, 0}), changed_(changed), protocol_(protocol) {}

// Relaxed: the number publishes no other data.
void UdpPort::OnConnect(const fci::Endpoint& client) noexcept {
  socket_.ListenOnlyTo(client);
  client_.store(Packed(client), std::memory_order_relaxed);
}

void UdpPort::Close() noexcept {
  socket_.ListenOnlyTo({});
  client_.store(0, std::memory_order_relaxed);
}

DroppedDatagrams UdpPort::dropped() const noexcept {
  return {foreign_.load(std::memory_order_relaxed) + socket_.dropped(),
          malformed_.load(std::memory_order_relaxed), early_.load(std::memory_order_relaxed)};
}

bool UdpPort::Receive(robot::ReceivedCommand& received) noexcept {
  while (looked_at_ < kMostAtOnce) {
    const auto datagram = socket_.Receive(incoming_);
    if (!datagram) break;
    ++looked_at_;
    Keep(datagram->at, datagram->from, socket_.local(), datagram->bytes);
    if (!Accept(*datagram, received.command)) continue;
    received.at = datagram->at;
    return true;
  }
  looked_at_ = 0;
  return false;
}

bool UdpPort::Accept(const fci::Datagram& datagram, RobotCommand& command) noexcept {
  if (Packed(datagram.from) != client_.load(std::memory_order_relaxed)) {
    CountOne(foreign_);
    return false;
  }
  const bool fits = datagram.bytes.size() == fci::CommandBytesOf(protocol_);
  if (!fits || fci::Decode(protocol_, datagram.bytes, command) != fci::DatagramFault::kNone) {
    CountOne(malformed_);
    return false;
  }
  if (command.message_id > newest_id_) {
    CountOne(early_);
    return false;
  }
  return true;
}

void UdpPort::Deliver(const RobotState& state) noexcept {
  newest_id_ = state.message_id;
  const std::uint64_t client = client_.load(std::memory_order_relaxed);
  if (client != 0) {
    const std::span<const std::byte> bytes = fci::Encode(protocol_, state, outgoing_);
    const fci::Endpoint to{static_cast<std::uint32_t>(client >> 16),
                           static_cast<std::uint16_t>(client)};
    // Captured before sending, because the answer may arrive before the next line. A datagram that
    // the system does not take is lost, as on the wire.
    if (capture_ != nullptr) Keep(clock_.Now(), socket_.local(), to, bytes);
    static_cast<void>(socket_.Send(bytes, to));
  }
  const bool is_same = state.robot_mode == mode_ && state.motion_generator_mode == generator_ &&
                       state.errors == errors_;
  if (is_same) return;
  mode_ = state.robot_mode;
  errors_ = state.errors;
  generator_ = state.motion_generator_mode;
  changed_.Notify();
}

void UdpPort::Keep(Time at, const fci::Endpoint& from, const fci::Endpoint& to,
                   std::span<const std::byte> bytes) noexcept {
  if (capture_ == nullptr) return;
  capture_->PutRealtime(
      {.at = at, .transport = record::Transport::kUdp, .from = from, .to = to, .bytes = bytes});
}

}  // namespace twin::server
