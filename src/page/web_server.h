#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "page/connection.h"
#include "twin/core/time.h"
#include "twin/fci/sockets.h"

namespace twin::page {

/// A file for those who have the token, in the header Authorization ("Bearer ..."). Its path
/// changes with its content: browsers may keep it.
struct PrivateFile {
  std::string path{};
  std::string token{};
  const std::string* bytes = nullptr;  ///< not null; must outlive the server
};

/// Address, permitted clients and resource limits of the server.
struct WebConfig {
  fci::Endpoint at{.address = 0x7f000001, .port = 8080};  ///< port 0: any free port
  std::optional<fci::Network> allow{};  ///< clients' network; absent: this machine only
  /// Limit of connections with the token; further ones get HTTP 503. The same limit holds for
  /// connections without it; there the oldest is dropped.
  std::size_t most_connections = 100;
  std::size_t longest_message = 4096;          ///< bytes; a longer message ends its connection
  std::size_t most_waiting = 64;               ///< frames; a longer queue drops its connection
  Duration timeout = std::chrono::seconds(5);  ///< for a request, and for sending a frame
  Duration tick = std::chrono::milliseconds(20);
  std::optional<PrivateFile> private_file{};
  Duration transfer_timeout = std::chrono::minutes(1);  ///< for sending a file
};

/// Serves the page's files over HTTP and its WebSocket at /ws (Boost.Beast). A request with another
/// Host, a WebSocket from a foreign page, and a malformed request or frame each end their own
/// connection only.
///
/// Threads: constructed and run by one; Stop() and Post() from any. Not real-time.
class WebServer {
 public:
  /// Listens from construction. @param listener  must outlive Run().
  /// @throws EnvironmentError naming port, reason and cure if the port cannot be opened.
  WebServer(const WebConfig& config, ConnectionListener& listener);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  [[nodiscard]] fci::Endpoint at() const noexcept;

  /// Serves until Stop(), then closes all connections.
  void Run();
  void Stop();
  /// Schedules `call` on the thread of Run().
  void Post(std::function<void()> call);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::page
