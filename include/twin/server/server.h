#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
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

/// What a server offers, and to whom.
struct ServerConfig {
  std::uint32_t address = 0x7f000001;        ///< of this machine, to listen at; 127.0.0.1
  std::uint16_t arm_port = fci::kArmPort;    ///< 0: any free one
  std::uint16_t hand_port = fci::kHandPort;  ///< the same; not opened without a hand
  /// Who may connect from elsewhere; absent: nobody. This machine may always.
  std::optional<fci::Network> allow;
  std::vector<std::byte>
      model_library;  ///< what LoadModelLibrary gives (x64 Linux); empty: nothing
  /// A connection that has not sent its Connect for so long is ended.
  Duration connect_timeout = std::chrono::seconds(10);
  /// Keeps what goes over TCP (over UDP: UdpPort::KeepIn); must outlive the server. Null: nothing.
  fci::Capture* capture = nullptr;
};

/// A robot that is served over the Franka Control Interface: TCP for requests, with the session's
/// order of events as in fci::ArmSession and fci::HandSession; states and commands pass through
/// UdpPort beside it.
///
///     client -- TCP --> Run(): poll, parse --> Move(), ... of the robot (rt::CallMailbox)
///     client <-- TCP -- answers            <-- its answers; the wake event when a motion has ended
///     client <-- UDP -- the robot's thread, UdpPort; the hand's states, every 10 ms, from Run()
///
/// The robot's thread never waits for TCP. One client of the arm and one of the hand at a time.
///
/// Decisions, where the real robot's ways are not public:
///   - A further client is accepted, its Connect read, and its connection then reset, so that its
///     library reports a broken connection at once (libfranka waits for ever on one that ends in
///     order). The session that is on is not touched.
///   - When a client is gone its motion is stopped; the next one's Connect is answered once the arm
///     has come to rest.
///   - What the hand does when its client goes, it goes on doing: it may hold something.
///   - There are no virtual walls: GetCartesianLimit succeeds with size zero, not active; but for
///     the one by which a twin says that it is one (fci/twin_sign.h).
///   - Deviations that a Move allows must be finite and not negative; they are not checked further.
///   - A model library is there for x64 Linux only.
///
/// Threads: the one that constructs it. Errors: a robot whose thread does not answer ends the
/// session that asked.
class Server {
 public:
  /// Listens from now on; clients wait until Run().
  /// @param robot, port, changed  that belong together; must outlive the server.
  /// @throws EnvironmentError when a port cannot be opened.
  Server(ServerConfig config, robot::ThreadedRobot& robot, UdpPort& port, WakeEvent& changed,
         const MonotonicClock& clock, TellPeople tell);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] fci::Endpoint arm() const;
  /// Absent: no hand is mounted.
  [[nodiscard]] std::optional<fci::Endpoint> hand() const;

  /// Serves until `ends` says so, which is asked at least every 100 ms. Then all connections are
  /// ended; those with requests that wait for an answer are reset.
  void Run(const std::function<bool()>& ends);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::server
