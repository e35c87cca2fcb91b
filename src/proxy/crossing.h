#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "proxy/lane.h"
#include "twin/core/clock.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/message_fate.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/bell.h"

namespace twin::proxy {

/// What happens to datagrams on the way.
struct Faults {
  rt::DirectionConfig state;
  rt::DirectionConfig command;
  std::uint64_t seed = 1;
};

/// Between whom they go.
struct Ends {
  fci::Endpoint client;           ///< its UDP
  std::uint32_t client_side = 0;  ///< this machine's address, as the client knows it
  std::uint32_t robot = 0;        ///< its address
  std::uint32_t robot_side = 0;   ///< this machine's address, as the robot knows it
};

/// One session's datagrams, relayed on a thread of their own while it lives.
///
///     robot --states--> robot_side_ -> state lane   -> client_side_ --states--> client
///     robot <-commands- robot_side_ <- command lane <- client_side_ <-commands- client
///
/// Threads: one makes and ends it. Real-time: its thread allocates nothing and takes no lock.
class Crossing {
 public:
  /// @throws EnvironmentError when a socket cannot be opened; InputError when the thread's settings
  /// are none of this machine's.
  Crossing(const MonotonicClock& clock, const Ends& ends, const Faults& faults,
           const rt::ThreadSettings& thread);
  ~Crossing();
  Crossing(const Crossing&) = delete;
  Crossing& operator=(const Crossing&) = delete;

  /// Where the robot has to send to.
  [[nodiscard]] std::uint16_t port() const noexcept { return robot_side_.local().port; }
  /// What the thread was not permitted, for people.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Ends it: nothing is relayed any more. Call once. @returns what became of all.
  [[nodiscard]] WayCounts End();

 private:
  /// A socket, and where what leaves by it goes to.
  class Gate final : public Exit {
   public:
    Gate(fci::UdpSocket& socket, const fci::Endpoint& to) : socket_(socket), to_(to) {}
    bool Send(std::span<const std::byte> bytes) noexcept override;
    /// @returns whether a datagram from there is listened to. @note The port is that of the first.
    [[nodiscard]] bool Knows(const fci::Endpoint& from) noexcept TWIN_REALTIME;

   private:
    fci::UdpSocket& socket_;
    fci::Endpoint to_;  ///< port 0: not known yet
  };

  void Run(const std::stop_token& stop);
  void TakeFrom(fci::UdpSocket& socket, Gate& gate, Lane& lane) noexcept TWIN_REALTIME;
  /// All that is due by then goes on.
  void RelayUntil(Time now) noexcept TWIN_REALTIME;
  void StopThread();

  const MonotonicClock& clock_;
  fci::UdpSocket client_side_;
  fci::UdpSocket robot_side_;
  Gate to_client_;
  Gate to_robot_;
  rt::EventQueue events_{2 * Lane::kMostEvents};
  Lane states_;
  Lane commands_;
  /// One byte more than is relayed: what fills it is too long.
  std::array<std::byte, kLongestPacket + 1> incoming_{};
  server::Bell end_;
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::proxy
