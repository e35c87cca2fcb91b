#pragma once

#include <optional>
#include <string>

#include "twin/core/time.h"
#include "twin/fci/arm_session.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"

namespace twin::server {

/// Where one client at a time is served: the arm's session or the hand's, with what it moves.
///
/// Threads: one.
class Desk {
 public:
  virtual ~Desk() = default;

  /// Whether the next client can be served already.
  [[nodiscard]] virtual bool IsReady() = 0;
  /// A client is about to send its first request. @param answers  go to it until Leave().
  virtual void Open(const fci::Endpoint& client, fci::Answers answers) = 0;
  /// @returns why its connection must be closed. @throws RobotFault.
  [[nodiscard]] virtual std::optional<std::string> OnFrame(const fci::Frame& frame) = 0;
  /// Something may have changed, or time has passed. @pre a client is served.
  virtual void OnTurn(Time now) = 0;
  [[nodiscard]] virtual bool has_pending() const = 0;
  /// The client is gone, or is going to be.
  virtual void Leave() = 0;
  /// After which time OnTurn() wants to be called again at the latest.
  [[nodiscard]] virtual Duration patience() const = 0;
};

}  // namespace twin::server
