#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/faults/message_fate.h"
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/request_handler.h"

namespace twin::proxy {

/// The robot, the permitted clients and the faults.
struct ProxyConfig {
  std::uint32_t address = 0x7f000001;        ///< of this machine, on which to listen; 127.0.0.1
  std::uint16_t arm_port = fci::kArmPort;    ///< 0: any free port
  std::optional<std::uint16_t> hand_port{};  ///< as arm_port; absent: fci::kHandPort
  /// Network that may connect, besides this machine; absent: this machine only.
  std::optional<fci::Network> allow;
  fci::Endpoint robot_arm;          ///< TCP address of the robot's arm
  fci::Endpoint robot_hand;         ///< TCP address of its hand; may be unreachable
  faults::DirectionConfig state;    ///< faults of datagrams from the robot
  faults::DirectionConfig command;  ///< faults of datagrams to the robot
  std::uint64_t seed = 1;           ///< of the faults
  int fifo_priority = 99;           ///< of the UDP threads: nothing delays relaying; 0: normal
  std::optional<int> cpu;           ///< of the UDP threads
  Duration connect_timeout = std::chrono::seconds(10);  ///< for a client's Connect
  Duration reach_timeout = std::chrono::seconds(3);     ///< for the connection to the robot

  /// @throws InputError naming the field that is out of range.
  void Validate() const;
};

/// Counts since construction.
struct ProxyCounts {
  RelayCounts arm;
  RelayCounts hand;
};

/// Relays datagrams with seeded delay, loss, duplication and reordering, in user space, between any
/// client and any server of the Franka Control Interface.
///
///     client <--TCP--> Run()'s thread, frame by frame -------------------------<--TCP--> robot
///     client <--UDP--> a real-time thread per session: faults::MessageFate, queue <--UDP--> robot
///
/// TCP passes unchanged, except for the UDP port in a Connect: the robot gets the proxy's port, so
/// that its datagrams come here. States go on to the client from the address to which it connected;
/// commands go to the states' source. Datagram contents are not inspected. The first datagram of a
/// session has number 0 in its direction; its fate is a function of configuration, seed, direction
/// and number. The hand's draws are independent of the arm's. A delay counts from the kernel's
/// receive time.
///
/// Decisions:
///   - One client at a time, as in the server: a further client is accepted, its first request is
///     read, and its connection is reset. A malformed frame from either side ends the connection.
///   - The proxy connects to the robot on a client's first request, and resets the client if it
///     cannot. When one side closes or breaks its connection, the other side's ends likewise. But a
///     client with an unanswered request is reset, because libfranka waits forever after a graceful
///     close.
///   - Only datagrams from the client (its TCP address, the UDP port that it announced) and the
///     robot (its address, the port of its first datagram) are accepted.
///   - Memory is bounded: robot::Channel's capacity in datagrams per direction, and 1 MiB of
///     answers that a client does not read. If the robot reads no requests, its client is
///     disconnected.
///   - TCP is neither delayed nor broken: it would repeat lost data and only become slow.
///
/// Threads: the constructing thread. Real-time: datagrams are relayed without locks or allocation.
class Proxy {
 public:
  /// Opens the ports; clients wait until Run().
  /// @param clock  must outlive the proxy.
  /// @param tell   receives one log line per event that matters to users.
  /// @throws InputError as ProxyConfig::Validate; EnvironmentError if a port cannot be opened.
  Proxy(const ProxyConfig& config, const MonotonicClock& clock, server::TellPeople tell);
  ~Proxy();
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  [[nodiscard]] fci::Endpoint hand() const;

  /// Relays until the predicate returns true; calls it at least every 100 ms, less often only while
  /// connecting to a robot. Then ends all connections.
  void Run(const std::function<bool()>& ends);

  /// Sums of the sessions that have ended.
  [[nodiscard]] ProxyCounts counts() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::proxy
