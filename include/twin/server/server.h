#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/fci/capture.h"
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"
#include "twin/robot/threaded_robot.h"
#include "twin/server/request_handler.h"
#include "twin/server/udp_port.h"
#include "twin/server/wake_event.h"

namespace twin::server {

/// What a server offers, and to which clients.
struct ServerConfig {
  std::uint32_t address = 0x7f000001;      ///< of this machine, on which to listen; 127.0.0.1
  std::uint16_t arm_port = fci::kArmPort;  ///< 0: any free port
  /// As arm_port; absent: the hand's own, fci::PortOf(). Not opened without a hand.
  std::optional<std::uint16_t> hand_port{};
  /// Network that may connect, besides this machine; absent: this machine only.
  std::optional<fci::Network> allow;
  fci::Protocol protocol = fci::Protocol::k5;  ///< that the arm speaks; ServedRobot sets its own
  std::string robot_model;                     ///< URDF that GetRobotModel gives; protocol 10
  std::vector<std::byte>
      model_library;  ///< what LoadModelLibrary gives (x64 Linux); empty: nothing
  /// A connection without a Connect for this long is closed.
  Duration connect_timeout = std::chrono::seconds(10);
  /// Called before the first request of each client of the arm, on the server's thread; may be
  /// empty.
  std::function<void()> on_arm_client;
  /// Records TCP traffic (for UDP: UdpPort::KeepIn); must outlive the server. May be null.
  fci::Capture* capture = nullptr;
};

/// Serves a robot over the Franka Control Interface. TCP carries requests, with the session order
/// of fci::ArmSession and fci::HandSession; UdpPort carries states and commands. The hand may be a
/// vacuum gripper.
///
///     client -- TCP --> Run(): poll, parse --> Move(), ... of the robot (rt::CallMailbox)
///     client <-- TCP -- answers            <-- its answers; the wake event when a motion has ended
///     client <-- UDP -- the robot's thread, UdpPort; the hand's states, every 10 ms, from Run()
///
/// The robot's thread never waits for TCP. Serves one client of the arm and one of the hand at a
/// time.
///
/// Decisions where the real robot's behaviour is not public:
///   - A further client is accepted, its Connect is read, and its connection is reset, so that its
///     library reports a broken connection at once (libfranka waits forever after a graceful
///     close). The running session is not affected.
///   - When a client disconnects, its motion is stopped. The next client's Connect is answered once
///     the arm is at rest.
///   - When the hand's client disconnects, the hand completes its command: it may hold an object.
///   - There are no virtual walls: GetCartesianLimit succeeds with size zero, not active.
///     Exception: the wall that identifies a twin (fci/twin_sign.h).
///   - A Move's deviations must be finite and not negative; no other check is made.
///   - The model library exists for x64 Linux only.
///
/// Threads: the constructing thread. Errors: if the robot's thread does not answer, the session
/// that made the request ends.
class Server {
 public:
  /// Opens the ports; clients wait until Run().
  /// @param robot, port, changed  must belong together and outlive the server.
  /// @throws EnvironmentError if a port cannot be opened.
  Server(ServerConfig config, robot::ThreadedRobot& robot, UdpPort& port, WakeEvent& changed,
         const MonotonicClock& clock, TellPeople tell);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  /// nullopt without a hand.
  [[nodiscard]] std::optional<fci::Endpoint> hand() const;

  /// Serves until `ends` returns true; calls it at least every 100 ms. Then ends all connections:
  /// resets those with unanswered requests, closes the others.
  void Run(const std::function<bool()>& ends);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::server
