#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "page/connection.h"
#include "twin/core/time.h"
#include "twin/fci/sockets.h"

namespace twin::page {

/// Where the page is, for whom, and what one of them may cost.
struct WebConfig {
  fci::Endpoint at{.address = 0x7f000001, .port = 8080};  ///< port 0: any free one
  std::optional<fci::Network> allow{};  ///< who may come from elsewhere; absent: nobody
  /// That have shown the token: a further one is told so (HTTP 503) and ended. Of as many that have
  /// not, the oldest makes room for a further one.
  std::size_t most_connections = 100;
  std::size_t longest_message = 4096;          ///< bytes; a longer one ends its connection
  std::size_t most_waiting = 64;               ///< frames; with more a connection is dropped
  Duration timeout = std::chrono::seconds(5);  ///< for a request, and for a frame to go out
  Duration tick = std::chrono::milliseconds(20);
};

/// Serves the page's files over HTTP and its WebSocket at /ws (Boost.Beast). What is not to be:
/// requests that do not name this machine as Host, WebSockets that pages from elsewhere ask for,
/// malformed requests and frames end their own connection and nothing else.
///
/// Threads: constructed and run by one; Stop() and Post() from any. Not real-time.
class WebServer {
 public:
  /// Listens from now on. @param listener  must outlive Run().
  /// @throws EnvironmentError when the port cannot be opened: which, why, and what to do.
  WebServer(const WebConfig& config, ConnectionListener& listener);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  [[nodiscard]] fci::Endpoint at() const noexcept;

  /// Serves until Stop(), then closes all connections.
  void Run();
  void Stop();
  /// Has `call` run on the thread of Run(), soon.
  void Post(std::function<void()> call);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::page
