#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/clock.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/fci/capture.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"
#include "twin/robot/workstation_port.h"
#include "twin/rt/signal.h"
#include "twin/server/wake_event.h"

namespace twin::server {

/// Datagrams that were dropped, by reason.
struct DroppedDatagrams {
  /// Not from the session's client, or beyond the queue's capacity. The kernel drops most of them
  /// (UdpSocket::ListenOnlyTo).
  std::uint64_t foreign = 0;
  std::uint64_t malformed = 0;  ///< wrong size, NaN, or a flag other than 0 or 1
  std::uint64_t early = 0;      ///< answers to states that were not sent yet
  bool operator==(const DroppedDatagrams&) const = default;
};

/// The network as a workstation: states and commands as datagrams on one socket, because clients
/// answer to the source of the states. Source: FCI protocol 5, transport.
///
///     network's thread:  OnConnect(client) ... Close()
///     robot's thread:    Deliver(state) --> socket; notifies the wake event on a new mode or error
///                        Receive() <------- socket, at most 64 datagrams per call
///
/// Between sessions no state is sent and all incoming datagrams are dropped.
///
/// Threads: OnConnect() and Close() from one, the robot's side from the robot's; counts from any.
/// Real-time: the robot's side neither waits (except in AwaitUntil()) nor allocates nor locks. A
/// change of mode notifies the wake event with a system call, as sending does.
class UdpPort final : public robot::WorkstationPort, public rt::Arrival {
 public:
  /// @param clock    the host's; must outlive the port. @param address  to bind, at any free port.
  /// @param protocol  of states and commands.
  /// @param changed  notified when a state has other modes or errors than the previous one; must
  /// outlive the port.
  /// @throws EnvironmentError as fci::UdpSocket.
  UdpPort(const MonotonicClock& clock, std::uint32_t address, WakeEvent& changed,
          fci::Protocol protocol = fci::Protocol::k5);

  /// Sends states to `client` and accepts its commands.
  void OnConnect(const fci::Endpoint& client) noexcept;
  void Close() noexcept;

  /// Records all datagrams. @param capture  must outlive the port; may be null. @pre no robot runs.
  void KeepIn(fci::Capture* capture) noexcept { capture_ = capture; }

  [[nodiscard]] fci::Endpoint local() const noexcept { return socket_.local(); }
  /// Since construction. Threads: any.
  [[nodiscard]] DroppedDatagrams dropped() const noexcept;

  [[nodiscard]] bool Receive(robot::ReceivedCommand& received) noexcept TWIN_REALTIME override;
  void Deliver(const RobotState& state) noexcept TWIN_REALTIME override;
  /// Waits until a datagram may have arrived.
  [[nodiscard]] bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME override {
    return socket_.AwaitUntil(deadline);
  }

 private:
  /// @returns true if the datagram is a command for the robot.
  [[nodiscard]] bool Accept(const fci::Datagram& datagram, RobotCommand& command) noexcept;

  void Keep(Time at, const fci::Endpoint& from, const fci::Endpoint& to,
            std::span<const std::byte> bytes) noexcept;

  const MonotonicClock& clock_;
  fci::UdpSocket socket_;
  fci::Capture* capture_ = nullptr;
  WakeEvent& changed_;
  const fci::Protocol protocol_;
  std::atomic<std::uint64_t> client_{0};  ///< address and port; 0: none

  std::atomic<std::uint64_t> foreign_{0};
  std::atomic<std::uint64_t> malformed_{0};
  std::atomic<std::uint64_t> early_{0};

  // Owned by the robot's thread.
  /// One byte longer than a command, to detect longer datagrams.
  std::array<std::byte, fci::kCommand10Bytes + 1> incoming_{};
  fci::StateBytes outgoing_{};
  int looked_at_ = 0;
  std::uint64_t newest_id_ = 0;
  RobotMode mode_ = RobotMode::kOther;
  RobotErrors errors_;
  MotionGeneratorMode generator_ = MotionGeneratorMode::kIdle;
};

}  // namespace twin::server
