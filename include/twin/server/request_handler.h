#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "twin/core/time.h"
#include "twin/fci/requests.h"
#include "twin/server/connection.h"

namespace twin::server {

/// Gets one line, without its end, for each thing worth telling people: who connected, how motions
/// ended, what was refused and why.
using TellPeople = std::function<void(std::string_view)>;

/// Where one client at a time is served: the arm's session or the hand's, with what it moves; or a
/// way to a robot that is elsewhere.
///
/// Threads: one.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  /// Whether the next client can be served already.
  [[nodiscard]] virtual bool IsReady() = 0;
  /// A client is about to send its first request. @param client  gets the answers; it is there
  /// until OnDisconnect() has returned.
  virtual void OnConnect(Connection& client) = 0;
  /// @returns why its connection must be closed. @throws RobotFault.
  [[nodiscard]] virtual std::optional<std::string> OnFrame(const fci::Frame& frame) = 0;
  /// Something may have changed, or time has passed. @pre a client is served.
  /// @returns as OnFrame(). @throws RobotFault.
  [[nodiscard]] virtual std::optional<std::string> Poll(Time now) = 0;
  /// Whether the client waits for an answer: its connection must then not end in order.
  [[nodiscard]] virtual bool has_pending() const = 0;
  /// The client is gone, or is going to be.
  virtual void OnDisconnect() = 0;
  /// After which time Poll() wants to be called again at the latest.
  [[nodiscard]] virtual Duration poll_timeout() const = 0;
};

}  // namespace twin::server
