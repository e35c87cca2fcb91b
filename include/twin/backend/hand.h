#pragma once

#include <optional>

#include "twin/core/hand_command.h"

namespace twin::backend {

/// The only seam to the hand or vacuum gripper, beside Backend and independent of what implements
/// it. Uses the vocabulary of the Franka Control Interface.
///
/// Life of a command: Start -> Outcome until it has a value. No call waits: a hand moves for
/// seconds, and in lockstep the caller advances time. One command runs at a time; a new command
/// aborts the previous one.
///
/// Threads: any, if the drive has several. Not for real-time code.
class Hand {
 public:
  virtual ~Hand() = default;

  /// Starts a command. @returns its ticket for Outcome(). @throws InputError naming a value out of
  /// range, the range and the cure; RobotFault if the hand does not answer.
  virtual HandTicket Start(const HandCommand& command) = 0;

  /// @returns how the command ended; nullopt while it runs. Keeps the last eight outcomes and
  /// reports older commands as aborted. @throws RobotFault if the hand does not answer.
  [[nodiscard]] virtual std::optional<HandResult> Outcome(HandTicket ticket) const = 0;

  /// The newest state. @throws RobotFault if the hand does not answer.
  [[nodiscard]] virtual HandState ReadState() const = 0;
};

}  // namespace twin::backend
