#pragma once

#include <poll.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/clock.h"
#include "twin/fci/sockets.h"
#include "twin/server/connection.h"
#include "twin/server/request_handler.h"

namespace twin::server {

/// A TCP port that serves one client at a time. A new connection stays pending until its first
/// request is complete; it then becomes the client or, while there is one, is refused.
///
/// Threads: one.
class SingleClientAcceptor {
 public:
  struct Settings {
    std::string_view name;  ///< for messages: "arm", "hand"
    fci::HeadKind kind{};
    std::size_t largest = 0;  ///< largest accepted request, bytes
    fci::Endpoint local;
    std::optional<fci::Network> allow;
    Duration connect_timeout{};
    Tap tap{};
  };

  /// @param config  ServerConfig or ProxyConfig: addresses and permitted clients.
  /// @returns settings without a tap.
  template <typename Config>
  [[nodiscard]] static Settings SettingsOf(const Config& config, fci::HeadKind kind) {
    const bool is_arm = kind == fci::HeadKind::kArm;
    return {.name = is_arm ? "arm" : "hand",
            .kind = kind,
            .largest = is_arm ? fci::kLargestArmRequest : fci::kLargestHandRequest,
            .local = {config.address,
                      is_arm ? config.arm_port : config.hand_port.value_or(fci::kHandPort)},
            .allow = config.allow,
            .connect_timeout = config.connect_timeout};
  }

  /// @param handler, tell  must outlive the acceptor. @throws EnvironmentError as fci::TcpListener.
  SingleClientAcceptor(const Settings& settings, RequestHandler& handler, const TellPeople& tell);

  [[nodiscard]] fci::Endpoint local() const { return listener_.local(); }

  /// Adds the descriptors to poll.
  void AddTo(std::vector<pollfd>& waited) const;
  /// Timeout for the poll.
  [[nodiscard]] Duration poll_timeout() const;
  /// Does all work that needs no waiting.
  void Serve(Time now);
  /// Closes all connections.
  void End();

 private:
  struct PendingClient {
    std::unique_ptr<Connection> connection;
    std::optional<fci::Frame> first;  ///< request; waits until the handler is ready
  };

  void Accept(Time now);
  /// Closes the pending connection that has been silent the longest.
  void DropSilent();
  [[nodiscard]] bool Admits(const fci::Endpoint& peer) const noexcept;
  /// @returns true if the pending connection was closed or became the client's.
  bool Receive(PendingClient& pending, Time now);
  void Take(PendingClient& pending);
  void ServeClient(Time now);
  void Handle(const fci::Frame& frame);
  /// Closes the client's connection for this reason.
  void Disconnect(const std::string& why, bool is_waiting);
  void Tell(const fci::Endpoint& whom, std::string_view what) const;

  const Settings settings_;
  fci::TcpListener listener_;
  RequestHandler& handler_;
  const TellPeople& tell_;
  std::vector<PendingClient> pending_;
  std::unique_ptr<Connection> client_;
};

}  // namespace twin::server
