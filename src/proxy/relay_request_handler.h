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

/// Relays a client to a robot's arm or hand: frames go to
/// the robot, the robot's bytes to it, and datagrams over a UdpRelay.
///
/// Threads: one.
class RelayRequestHandler final : public server::RequestHandler {
 public:
  struct Settings {
    std::string_view name;  ///< for people: "arm", "hand"
    fci::HeadKind kind{};
    fci::Endpoint robot;  ///< its TCP
    Duration reach_timeout{};
    Faults faults;
    rt::ThreadSettings thread;  ///< of datagrams
  };

  /// @param clock, tell  must outlive the handler.
  RelayRequestHandler(const Settings& settings, const MonotonicClock& clock,
                      const server::TellPeople& tell);

  /// Adds what to wait at.
  void AddTo(std::vector<pollfd>& waited) const;
  /// Of sessions that have ended.
  [[nodiscard]] const RelayCounts& counts() const noexcept { return counts_; }

  [[nodiscard]] bool IsReady() override { return true; }
  void OnConnect(server::Connection& client) override { client_ = &client; }
  [[nodiscard]] std::optional<std::string> OnFrame(const fci::Frame& frame) override;
  [[nodiscard]] std::optional<std::string> Poll(Time now) override;
  /// The robot has broken its connection: so is the client's. Or it owes an answer: clients wait
  /// for ever on a connection that endpoints in order then.
  [[nodiscard]] bool has_pending() const override { return is_broken_ || owed_ > 0; }
  void OnDisconnect() override;
  [[nodiscard]] Duration poll_timeout() const override;

 private:
  void Reach();
  /// @returns as OnFrame().
  [[nodiscard]] std::optional<std::string> Forward(std::span<const std::byte> bytes);
  /// The frame as it goes on: a Connect with another UDP port, whose datagrams are relayed then.
  [[nodiscard]] std::vector<std::byte> Passed(const fci::Frame& frame);
  [[nodiscard]] std::uint16_t Cross(std::uint16_t client_port);
  void EndCrossing();
  /// Of what the robot has sent.
  void CountAnswers();

  const Settings settings_;
  const MonotonicClock& clock_;
  const server::TellPeople& tell_;
  RelayCounts counts_;
  bool noticed_ = false;  ///< what the thread is not permitted was told

  // A session's.
  server::Connection* client_ = nullptr;
  std::optional<fci::TcpStream> robot_;
  std::optional<fci::FrameReader> answers_;  ///< the robot's bytes, which pass as they come
  std::uint64_t owed_ = 0;                   ///< requests that were not answered to their end
  std::optional<UdpRelay> relay_;
  bool is_broken_ = false;
};

}  // namespace twin::proxy
