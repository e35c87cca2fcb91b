#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "twin/core/time.h"
#include "twin/fci/requests.h"
#include "twin/server/connection.h"

namespace twin::server {

/// Receives one log line (no newline) per event that matters to users: connections, ends of
/// motions, refusals with their reason.
using TellPeople = std::function<void(std::string_view)>;

/// Serves one client at a time: a session with the arm or the hand, or a relay to a remote robot.
///
/// Threads: one.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  /// True if the next client can be served.
  [[nodiscard]] virtual bool IsReady() = 0;
  /// A client is about to send its first request. @param client  receives the answers; valid until
  /// OnDisconnect() has returned.
  virtual void OnConnect(Connection& client) = 0;
  /// @returns a reason to close the connection, or nullopt. @throws RobotFault.
  [[nodiscard]] virtual std::optional<std::string> OnFrame(const fci::Frame& frame) = 0;
  /// Handles changes of the robot and the passage of time. @pre a client is served.
  /// @returns as OnFrame(). @throws RobotFault.
  [[nodiscard]] virtual std::optional<std::string> Poll(Time now) = 0;
  /// True while the client waits for an answer: its connection must then be reset, not closed.
  [[nodiscard]] virtual bool has_pending() const = 0;
  /// The client has disconnected, or is about to be disconnected.
  virtual void OnDisconnect() = 0;
  /// Longest time until the next call of Poll().
  [[nodiscard]] virtual Duration poll_timeout() const = 0;
};

}  // namespace twin::server
