#pragma once

#include <optional>

#include "twin/core/hand_command.h"

namespace twin::backend {

/// The only seam to the hand; beside Backend, as small, and as ignorant of what is behind it.
/// Speaks the vocabulary of the Franka Control Interface.
///
/// Life of a command: Start -> Outcome until it tells one. Nothing waits here: a hand moves for
/// seconds, and in lockstep it is the caller who lets time pass. One command runs at a time; a new
/// one aborts the one before.
///
/// Threads: any, where the drive has several. Not for real-time code.
class Hand {
 public:
  virtual ~Hand() = default;

  /// Starts a command. @returns its name for Outcome(). @throws InputError when a value is out of
  /// range, naming it, the range and the cure; RobotFault when the hand does not answer.
  virtual HandTicket Start(const HandCommand& command) = 0;

  /// @returns how the command ended; nothing while it runs. Asked of one of the last eight; of
  /// earlier ones it tells that they were aborted. @throws RobotFault when the hand does not
  /// answer.
  [[nodiscard]] virtual std::optional<HandResult> Outcome(HandTicket ticket) const = 0;

  /// The newest state. @throws RobotFault when the hand does not answer.
  [[nodiscard]] virtual HandState ReadState() const = 0;
};

}  // namespace twin::backend
