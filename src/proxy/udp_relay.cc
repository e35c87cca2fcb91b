#include "proxy/udp_relay.h"

#include <poll.h>

#include <utility>

namespace twin::proxy {
namespace {

/// Datagrams per turn; bounds the time that a flood can cost.
constexpr int kMostAtOnce = 64;

}  // namespace

bool UdpRelay::Peer::Send(std::span<const std::byte> bytes) noexcept {
  return to_.port != 0 && socket_.Send(bytes, to_);
}

bool UdpRelay::Peer::Knows(const fci::Endpoint& from) noexcept {
  if (to_.port == 0 && from.address == to_.address) {
    to_.port = from.port;
    socket_.ListenOnlyTo(to_);
  }
  return from == to_;
}

UdpRelay::UdpRelay(const MonotonicClock& clock, const Endpoints& endpoints, const Faults& faults,
                   const rt::ThreadSettings& thread)
    : clock_(clock),
      client_side_(clock, {endpoints.client_side, 0}),
      robot_side_(clock, {endpoints.robot_side, 0}),
      to_client_(client_side_, endpoints.client),
      to_robot_(robot_side_, {endpoints.robot, 0}),
      states_(faults.state, faults.seed, faults::kStateStreams, events_,
              rt::EventOrder::kStateArrival, to_client_),
      commands_(faults.command, faults.seed, faults::kCommandStreams, events_,
                rt::EventOrder::kCommandArrival, to_robot_) {
  client_side_.ListenOnlyTo(endpoints.client);
  rt::StartedThread started =
      rt::StartThread(thread, [this](const std::stop_token& stop) { Run(stop); });
  thread_ = std::move(started.thread);
  notices_ = std::move(started.notices);
}

UdpRelay::~UdpRelay() {
  StopThread();
}

void UdpRelay::StopThread() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  end_.Notify();
  thread_.join();
}

RelayCounts UdpRelay::End() {
  StopThread();
  return {states_.counts(), commands_.counts()};
}

void UdpRelay::Run(const std::stop_token& stop) {
  std::array<pollfd, 3> waited{
      {{robot_side_.fd(), POLLIN, 0}, {client_side_.fd(), POLLIN, 0}, {end_.fd(), POLLIN, 0}}};
  while (!stop.stop_requested()) {
    static_cast<void>(fci::AwaitAny(waited, clock_, events_.NextTime().value_or(Time::max())));
    TakeFrom(robot_side_, to_robot_, states_);
    TakeFrom(client_side_, to_client_, commands_);
    RelayUntil(clock_.Now());
  }
}

void UdpRelay::TakeFrom(fci::UdpSocket& socket, Peer& peer, RelayDirection& direction) noexcept {
  for (int i = 0; i < kMostAtOnce; ++i) {
    const auto datagram = socket.Receive(incoming_);
    if (!datagram) return;
    if (!peer.Knows(datagram->from)) {
      direction.CountForeign();
      continue;
    }
    RelayUntil(datagram->at);
    direction.Take(datagram->bytes);
  }
}

void UdpRelay::RelayUntil(Time now) noexcept {
  for (auto next = events_.NextTime(); next && *next <= now; next = events_.NextTime()) {
    events_.RunNext();
  }
  events_.AdvanceTo(now);
}

}  // namespace twin::proxy
