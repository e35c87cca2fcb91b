#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/message_fate.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/request_handler.h"

namespace twin::proxy {

/// Which robot, for whom, and what happens on the way.
struct ProxyConfig {
  std::uint32_t address = 0x7f000001;        ///< of this machine, to listen at; 127.0.0.1
  std::uint16_t arm_port = fci::kArmPort;    ///< 0: any free one
  std::uint16_t hand_port = fci::kHandPort;  ///< the same
  /// Who may connect from elsewhere; absent: nobody. This machine may always.
  std::optional<fci::Network> allow;
  fci::Endpoint robot_arm;      ///< TCP of the robot's arm
  fci::Endpoint robot_hand;     ///< and of its hand, which need not be there
  rt::DirectionConfig state;    ///< faults of datagrams from the robot
  rt::DirectionConfig command;  ///< and to it
  std::uint64_t seed = 1;       ///< of the faults
  int fifo_priority = 99;       ///< of the threads of UDP: a wire waits for nobody. 0: ordinary
  std::optional<int> cpu;       ///< of them
  Duration connect_timeout = std::chrono::seconds(10);  ///< for a client's Connect
  Duration reach_timeout = std::chrono::seconds(3);     ///< for the robot to take a connection

  /// @throws InputError naming the field that is out of range.
  void Validate() const;
};

/// Since construction.
struct ProxyCounts {
  RelayCounts arm;
  RelayCounts hand;
};

/// A way to a robot that delays, loses, doubles and reorders datagrams, by a seed: between any
/// client and any server of the Franka Control Interface, in user space.
///
///     client <--TCP--> Run()'s thread, frame by frame -------------------------<--TCP--> robot
///     client <--UDP--> a real-time thread per session: rt::MessageFate, queue <--UDP--> robot
///
/// TCP passes unchanged, but for the UDP port in a Connect: the robot is told the proxy's, so that
/// its datagrams come here. They go on to the client from the address it has connected to; its
/// commands go to where states come from. Datagrams are not looked into: what they say is the
/// endpoints' affair. The first of a session's has number 0 in its direction, and its fate is a
/// function of the configuration, the seed, the direction and that number; the hand's are drawn
/// apart from the arm's. A datagram's delay counts from when the system received it.
///
/// Decisions:
///   - One client at a time, as the server has it: a further one is accepted, its first request
///     read, and its connection reset. What is no frame, of either side, endpoints the connection.
///   - The robot is connected when a client's first request is there. When it cannot be, the client
///     is reset. However one side endpoints, in order or broken, so is the other; but a client to
///     whom the robot owes an answer is reset, since libfranka waits for ever on one that endpoints
///     in order.
///   - Only the client (the address of its TCP connection, the port it has told) and the robot (its
///     address, and the port its first datagram came from) are listened to.
///   - Memory is bounded: robot::Channel's capacity in datagrams of each direction, a MiB of
///   answers
///     that a client does not read. A robot that takes no requests loses its client.
///   - TCP is neither delayed nor broken: it would repeat what is lost, and only be slow.
///
/// Threads: the one that constructs it. Real-time: a session's datagrams are relayed without locks
/// and without allocation.
class Proxy {
 public:
  /// Listens from now on; clients wait until Run().
  /// @param clock  must outlive the proxy.
  /// @param tell   one line for each thing worth telling people.
  /// @throws InputError as ProxyConfig::Validate; EnvironmentError when a port cannot be opened.
  Proxy(const ProxyConfig& config, const MonotonicClock& clock, server::TellPeople tell);
  ~Proxy();
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  [[nodiscard]] fci::Endpoint hand() const;

  /// Relays until `endpoints` says so, which is asked at least every 100 ms, later only while a
  /// robot is being reached. Then all connections are ended.
  void Run(const std::function<bool()>& endpoints);

  /// Of sessions that have ended.
  [[nodiscard]] ProxyCounts counts() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::proxy
