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
#include "twin/rt/arrival.h"
#include "twin/server/wake_event.h"

namespace twin::server {

/// Datagrams that were not passed on, by why.
struct DroppedDatagrams {
  /// Of somebody who is not the session's client, or more than wait at once: mostly the kernel
  /// drops them, before they are anybody's work (UdpSocket::ListenOnlyTo).
  std::uint64_t foreign = 0;
  std::uint64_t malformed =
      0;                    ///< of another size than a command's, with NaN or a flag that is none
  std::uint64_t early = 0;  ///< answers to states that were not sent yet
  bool operator==(const DroppedDatagrams&) const = default;
};

/// The workstation beyond the network: states and commands as datagrams, over one socket, since
/// clients answer to where states come from. Source: FCI protocol 5, transport.
///
///     network's thread:  OnConnect(client) ... Close()
///     robot's thread:    Deliver(state) --> socket, and the wake event when mode or errors changed
///                        Receive() <------- socket, 64 datagrams at most in one go
///
/// Between sessions no state leaves and nothing that comes is let in.
///
/// Threads: OnConnect() and Close() from one, the robot's end from the robot's; counts from any.
/// Real-time: the robot's end neither waits (but AwaitUntil()), allocates nor locks; a change of
/// mode notifies the wake event by a system call, as sending does.
class UdpPort final : public robot::WorkstationPort, public rt::Arrival {
 public:
  /// @param clock    of the host; must outlive the port. @param address  to bind, any free port.
  /// @param changed  notified when a state shows other modes or errors than the last; must outlive
  /// the port.
  /// @throws EnvironmentError as fci::UdpSocket.
  UdpPort(const MonotonicClock& clock, std::uint32_t address, WakeEvent& changed);

  /// States go to, and commands come from `client`.
  void OnConnect(const fci::Endpoint& client) noexcept;
  void Close() noexcept;

  /// Keeps what passes. @param capture  must outlive the port; null: nothing is kept. @pre no robot
  /// runs.
  void KeepIn(fci::Capture* capture) noexcept { capture_ = capture; }

  [[nodiscard]] fci::Endpoint local() const noexcept { return socket_.local(); }
  /// Since construction. Any thread.
  [[nodiscard]] DroppedDatagrams dropped() const noexcept;

  [[nodiscard]] bool Receive(robot::ReceivedCommand& received) noexcept TWIN_REALTIME override;
  void Deliver(const RobotState& state) noexcept TWIN_REALTIME override;
  /// Until a datagram may have come.
  [[nodiscard]] bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME override {
    return socket_.AwaitUntil(deadline);
  }

 private:
  /// @returns whether the datagram is a command for the robot.
  [[nodiscard]] bool Accept(const fci::Datagram& datagram, RobotCommand& command) noexcept;

  void Keep(Time at, const fci::Endpoint& from, const fci::Endpoint& to,
            std::span<const std::byte> bytes) noexcept;

  const MonotonicClock& clock_;
  fci::UdpSocket socket_;
  fci::Capture* capture_ = nullptr;
  WakeEvent& changed_;
  std::atomic<std::uint64_t> client_{0};  ///< address and port; 0: none

  std::atomic<std::uint64_t> foreign_{0};
  std::atomic<std::uint64_t> malformed_{0};
  std::atomic<std::uint64_t> early_{0};

  // The robot's thread's.
  /// One byte more than a command has: what fills it is too long.
  std::array<std::byte, fci::kCommandBytes + 1> incoming_{};
  fci::StateBytes outgoing_{};
  int looked_at_ = 0;
  std::uint64_t newest_id_ = 0;
  RobotMode mode_ = RobotMode::kOther;
  RobotErrors errors_;
  MotionGeneratorMode generator_ = MotionGeneratorMode::kIdle;
};

}  // namespace twin::server
