#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <poll.h>

#include "proxy/udp_relay.h"
#include "twin/core/clock.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/sockets.h"
#include "twin/proxy/counts.h"
#include "twin/rt/thread_setup.h"
#include "twin/server/request_handler.h"

namespace twin::proxy {

/// Relays a client to a robot's arm or hand: frames to the robot, the robot's bytes to the client,
/// and datagrams through a UdpRelay.
///
/// Threads: one.
class RelayRequestHandler final : public server::RequestHandler {
 public:
  struct Settings {
    std::string_view name;  ///< for messages: "arm", "hand"
    fci::HeadKind kind{};
    fci::Endpoint robot;  ///< TCP address
    Duration reach_timeout{};
    Faults faults;
    rt::ThreadSettings thread;  ///< of the UDP relay
  };

  /// @param clock, tell  must outlive the handler.
  RelayRequestHandler(const Settings& settings, const MonotonicClock& clock,
                      const server::TellPeople& tell);

  /// Adds the descriptors to poll.
  void AddTo(std::vector<pollfd>& waited) const;
  /// Sums of the sessions that have ended.
  [[nodiscard]] const RelayCounts& counts() const noexcept { return counts_; }

  [[nodiscard]] bool IsReady() override { return true; }
  void OnConnect(server::Connection& client) override { client_ = &client; }
  [[nodiscard]] std::optional<std::string> OnFrame(const fci::Frame& frame) override;
  [[nodiscard]] std::optional<std::string> Poll(Time now) override;
  /// True if the robot has broken its connection or owes an answer: the client's must then be
  /// reset, because clients wait forever after a graceful close.
  [[nodiscard]] bool has_pending() const override { return is_broken_ || owed_ > 0; }
  void OnDisconnect() override;
  [[nodiscard]] Duration poll_timeout() const override;

 private:
  void Reach();
  /// @returns as OnFrame().
  [[nodiscard]] std::optional<std::string> Forward(std::span<const std::byte> bytes);
  /// The frame to forward. A Connect gets the proxy's UDP port, and its datagrams are relayed from
  /// then on.
  [[nodiscard]] std::vector<std::byte> Passed(const fci::Frame& frame);
  [[nodiscard]] std::uint16_t Cross(std::uint16_t client_port);
  void EndRelay();
  /// Counts the answers in the robot's bytes.
  void CountAnswers();

  const Settings settings_;
  const MonotonicClock& clock_;
  const server::TellPeople& tell_;
  RelayCounts counts_;
  bool noticed_ = false;  ///< the thread's missing permissions were logged

  // State of one session.
  server::Connection* client_ = nullptr;
  std::optional<fci::TcpStream> robot_;
  std::optional<fci::FrameReader>
      answers_;             ///< parses a copy of the robot's bytes, which are relayed unchanged
  std::uint64_t owed_ = 0;  ///< requests without their last answer
  std::optional<UdpRelay> relay_;
  bool is_broken_ = false;
};

}  // namespace twin::proxy
