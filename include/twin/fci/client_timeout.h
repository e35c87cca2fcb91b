#pragma once

#include "twin/core/time.h"

namespace twin::fci {

/// Timeouts of a client. All are finite: a silent robot causes an error message, not a hang.
struct ClientTimeout {
  Duration connect = std::chrono::seconds(3);  ///< for the connection and the answer to Connect
  /// For the answer to a request; StopMove and recovery answer once the arm is at rest.
  Duration answer = std::chrono::seconds(10);
  Duration state = std::chrono::seconds(1);  ///< between states; as in libfranka
};

}  // namespace twin::fci
