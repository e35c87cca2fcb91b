#pragma once

#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::robot {

/// A command as it came to the robot.
struct ReceivedCommand {
  RobotCommand command;
  Time at{};  ///< when, on the clock of the robot's host: what INT's deadline is compared with
};

/// Where a robot on a thread of its own meets its workstation: slots of the same process, or the
/// network. The robot's end; what the other end looks like is the port's own.
///
/// Threads: both calls from the robot's thread. Real-time: neither waits, allocates or locks.
class WorkstationPort {
 public:
  virtual ~WorkstationPort() = default;

  /// The next command that has come, in the order of coming. @param received  written when there
  /// is one. @returns false when none waits, or when as much was looked at as fits in one go: the
  /// call after that looks on.
  [[nodiscard]] virtual bool Receive(ReceivedCommand& received) noexcept TWIN_REALTIME = 0;

  /// A state has come through the robot's link, for the workstation.
  virtual void Deliver(const RobotState& state) noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::robot
