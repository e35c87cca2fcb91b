#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace twin::page {

/// A message to a browser over the WebSocket.
struct Frame {
  std::string bytes;
  bool is_text = true;  ///< false: a picture
};

/// Shared by the browsers that receive it.
using SharedFrame = std::shared_ptr<const Frame>;

/// A browser at the other end of a WebSocket. Threads: the web server's.
class Connection {
 public:
  virtual ~Connection() = default;
  /// Queues a frame. The server drops a connection that reads nothing for seconds, or whose queue
  /// is full.
  virtual void Send(SharedFrame frame) = 0;
  /// Frames still in the queue.
  [[nodiscard]] virtual std::size_t waiting() const noexcept = 0;
  /// The client has sent the token: the connection is no longer dropped to make room. Call once.
  virtual void Authenticate() = 0;
  /// Closes the connection gracefully and ignores further input.
  virtual void Close(std::string_view reason) = 0;
};

/// Receives the events of all connections, on the web server's thread and never from within a call
/// to a Connection. Each connection connects once and disconnects once.
class ConnectionListener {
 public:
  virtual ~ConnectionListener() = default;
  virtual void OnConnect(Connection& connection) = 0;
  virtual void OnText(Connection& connection, std::string_view text) = 0;
  /// The connection is destroyed after this returns.
  virtual void OnDisconnect(Connection& connection) = 0;
  /// Called every WebConfig::tick.
  virtual void OnTick() = 0;
};

}  // namespace twin::page
