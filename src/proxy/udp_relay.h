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
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/message_fate.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/wake_event.h"

namespace twin::proxy {

/// What happens to datagrams on the way.
struct Faults {
  rt::DirectionConfig state;
  rt::DirectionConfig command;
  std::uint64_t seed = 1;
};

/// The addresses of both sides.
struct Endpoints {
  fci::Endpoint client;           ///< its UDP
  std::uint32_t client_side = 0;  ///< this machine's address, as the client knows it
  std::uint32_t robot = 0;        ///< its address
  std::uint32_t robot_side = 0;   ///< this machine's address, as the robot knows it
};

/// One session's datagrams, relayed on a thread of their own while it lives.
///
///     robot --states--> robot_side_ -> state direction   -> client_side_ --states--> client
///     robot <-commands- robot_side_ <- command direction <- client_side_ <-commands- client
///
/// Threads: one makes and endpoints it. Real-time: its thread allocates nothing and takes no lock.
class UdpRelay {
 public:
  /// @throws EnvironmentError when a socket cannot be opened; InputError when the thread's settings
  /// are none of this machine's.
  UdpRelay(const MonotonicClock& clock, const Endpoints& endpoints, const Faults& faults,
           const rt::ThreadSettings& thread);
  ~UdpRelay();
  UdpRelay(const UdpRelay&) = delete;
  UdpRelay& operator=(const UdpRelay&) = delete;

  /// Where the robot has to send to.
  [[nodiscard]] std::uint16_t port() const noexcept { return robot_side_.local().port; }
  /// What the thread was not permitted, for people.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Endpoints it: nothing is relayed any more. Call once. @returns what became of all.
  [[nodiscard]] RelayCounts End();

 private:
  /// The peer on one side: its address, and the socket to it.
  class Peer final : public Output {
   public:
    Peer(fci::UdpSocket& socket, const fci::Endpoint& to) : socket_(socket), to_(to) {}
    bool Send(std::span<const std::byte> bytes) noexcept override;
    /// @returns whether a datagram from there is listened to. @note The port is that of the first.
    [[nodiscard]] bool Knows(const fci::Endpoint& from) noexcept TWIN_REALTIME;

   private:
    fci::UdpSocket& socket_;
    fci::Endpoint to_;  ///< port 0: not known yet
  };

  void Run(const std::stop_token& stop);
  void TakeFrom(fci::UdpSocket& socket, Peer& peer,
                RelayDirection& direction) noexcept TWIN_REALTIME;
  /// All that is due by then goes on.
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
  /// One byte more than is relayed: what fills it is too long.
  std::array<std::byte, kLongestPacket + 1> incoming_{};
  server::WakeEvent end_;
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::proxy
