#pragma once

#include "twin/core/time.h"

namespace twin::fci {

/// How long a client waits. Finite, all of it: a robot that says nothing ends in a message, not in
/// a program that hangs.
struct ClientTimeout {
  Duration connect = std::chrono::seconds(3);  ///< for the connection, and its answer
  /// For the answer to a request: StopMove and recovery answer once the arm rests.
  Duration answer = std::chrono::seconds(10);
  Duration state = std::chrono::seconds(1);  ///< without a state; libfranka's figure
};

}  // namespace twin::fci
