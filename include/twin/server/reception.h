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
#include "twin/server/desk.h"

namespace twin::server {

/// A TCP port and its one desk: whoever connects is a visitor until its first request is whole,
/// then the desk's client or, when the desk has one, sent away.
///
/// Threads: one.
class Reception {
 public:
  struct Settings {
    std::string_view name;  ///< for people: "arm", "hand"
    fci::HeadKind kind{};
    std::size_t largest = 0;  ///< request
    fci::Endpoint local;
    std::optional<fci::Network> allow;
    Duration connect_timeout{};
    Tap tap{};
  };

  /// @param config  ServerConfig or ProxyConfig: where both listen, and who may connect.
  /// @returns settings without a tap.
  template <typename Config>
  [[nodiscard]] static Settings SettingsOf(const Config& config, fci::HeadKind kind) {
    const bool is_arm = kind == fci::HeadKind::kArm;
    return {.name = is_arm ? "arm" : "hand",
            .kind = kind,
            .largest = is_arm ? fci::kLargestArmRequest : fci::kLargestHandRequest,
            .local = {config.address, is_arm ? config.arm_port : config.hand_port},
            .allow = config.allow,
            .connect_timeout = config.connect_timeout};
  }

  /// @param desk, tell  must outlive the reception. @throws EnvironmentError as fci::TcpListener.
  Reception(const Settings& settings, Desk& desk, const TellPeople& tell);

  [[nodiscard]] fci::Endpoint local() const { return listener_.local(); }

  /// Adds what to wait at.
  void AddTo(std::vector<pollfd>& waited) const;
  /// For how long.
  [[nodiscard]] Duration poll_timeout() const;
  /// Does what can be done without waiting.
  void Serve(Time now);
  /// Ends all connections.
  void End();

 private:
  struct Visitor {
    std::unique_ptr<Connection> connection;
    std::optional<fci::Frame> first;  ///< request, that waits for the desk to become ready
  };

  void Accept(Time now);
  /// Makes room: the one that has said nothing for longest goes.
  void DropSilent();
  [[nodiscard]] bool Admits(const fci::Endpoint& peer) const noexcept;
  /// @returns whether the visitor has left, or become the client.
  bool Receive(Visitor& visitor, Time now);
  void Take(Visitor& visitor);
  void ServeClient(Time now);
  void Handle(const fci::Frame& frame);
  /// The client's connection ends for this reason.
  void Dismiss(const std::string& why, bool is_waiting);
  void Tell(const fci::Endpoint& whom, std::string_view what) const;

  const Settings settings_;
  fci::TcpListener listener_;
  Desk& desk_;
  const TellPeople& tell_;
  std::vector<Visitor> visitors_;
  std::unique_ptr<Connection> client_;
};

}  // namespace twin::server
