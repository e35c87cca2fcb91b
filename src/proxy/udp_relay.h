#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "proxy/relay_direction.h"
#include "twin/core/clock.h"
#include "twin/faults/message_fate.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/wake_event.h"

namespace twin::proxy {

/// Faults of both directions.
struct Faults {
  faults::DirectionConfig state;
  faults::DirectionConfig command;
  std::uint64_t seed = 1;
};

/// Addresses of both sides.
struct Endpoints {
  fci::Endpoint client;           ///< UDP address
  std::uint32_t client_side = 0;  ///< this machine's address as seen by the client
  std::uint32_t robot = 0;        ///< the robot's address
  std::uint32_t robot_side = 0;   ///< this machine's address as seen by the robot
};

/// Relays one session's datagrams on a thread of its own, from construction to End().
///
///     robot --states--> robot_side_ -> state direction   -> client_side_ --states--> client
///     robot <-commands- robot_side_ <- command direction <- client_side_ <-commands- client
///
/// Threads: one constructs and ends it. Real-time: the relay thread neither allocates nor locks.
class UdpRelay {
 public:
  /// @throws EnvironmentError if a socket cannot be opened; InputError if this machine does not
  /// support the thread's settings.
  UdpRelay(const MonotonicClock& clock, const Endpoints& endpoints, const Faults& faults,
           const rt::ThreadSettings& thread);
  ~UdpRelay();
  UdpRelay(const UdpRelay&) = delete;
  UdpRelay& operator=(const UdpRelay&) = delete;

  /// Port to which the robot sends its datagrams.
  [[nodiscard]] std::uint16_t port() const noexcept { return robot_side_.local().port; }
  /// Permissions that the thread did not get, for users.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Stops relaying. Call once. @returns the session's counts.
  [[nodiscard]] RelayCounts End();

 private:
  /// The peer on one side: its address, and the socket for it.
  class Peer final : public Output {
   public:
    Peer(fci::UdpSocket& socket, const fci::Endpoint& to) : socket_(socket), to_(to) {}
    bool Send(std::span<const std::byte> bytes) noexcept override;
    /// @returns true if the source is the peer. @note The first datagram sets the port.
    [[nodiscard]] bool Knows(const fci::Endpoint& from) noexcept TWIN_REALTIME;

   private:
    fci::UdpSocket& socket_;
    fci::Endpoint to_;  ///< port 0: not known yet
  };

  void Run(const std::stop_token& stop);
  void TakeFrom(fci::UdpSocket& socket, Peer& peer,
                RelayDirection& direction) noexcept TWIN_REALTIME;
  /// Sends all datagrams due by then.
  void RelayUntil(Time now) noexcept TWIN_REALTIME;
  void StopThread();

  const MonotonicClock& clock_;
  fci::UdpSocket client_side_;
  fci::UdpSocket robot_side_;
  Peer to_client_;
  Peer to_robot_;
  rt::EventQueue events_{2 * RelayDirection::kMostEvents};
  RelayDirection states_;
  RelayDirection commands_;
  /// One byte longer than the longest relayed datagram, to detect longer ones.
  std::array<std::byte, kLongestPacket + 1> incoming_{};
  server::WakeEvent end_;
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::proxy
