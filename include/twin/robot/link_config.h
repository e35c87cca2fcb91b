#pragma once

#include "twin/core/time.h"
#include "twin/rt/message_fate.h"

namespace twin::robot {

/// What one direction of the link does to its messages.
using DirectionConfig = rt::DirectionConfig;

/// The longest a message may be on the way; one that would take longer counts as lost. It would be
/// overtaken by its successors and dropped on arrival anyway.
inline constexpr Duration kLongestOnTheWay = 255 * kCycle;

/// The way between the robot and the workstation.
struct LinkConfig {
  DirectionConfig state;    ///< robot -> workstation
  DirectionConfig command;  ///< workstation -> robot
  /// INT's own processing: a command counts for cycle k only if it arrived by t_k - d_INT.
  Duration d_INT = std::chrono::microseconds(100);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
