#pragma once

#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::robot {

/// A command with its arrival time.
struct ReceivedCommand {
  RobotCommand command;
  Time at{};  ///< arrival on the clock of the robot's host; INT's deadline applies to it
};

/// The robot's end of its connection to a workstation, in the same process or over the network.
/// Implementations define the other end.
///
/// Threads: both calls from the robot's thread. Real-time: neither waits, allocates or locks.
class WorkstationPort {
 public:
  virtual ~WorkstationPort() = default;

  /// Takes the next command in the order of arrival. @param received  written if there is one.
  /// @returns false when none waits, or when a bounded amount of input has been read; the next call
  /// continues.
  [[nodiscard]] virtual bool Receive(ReceivedCommand& received) noexcept TWIN_REALTIME = 0;

  /// Delivers a state that has passed the robot's link to the workstation.
  virtual void Deliver(const RobotState& state) noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::robot
