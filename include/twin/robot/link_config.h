#pragma once

#include "twin/core/time.h"
#include "twin/rt/message_fate.h"

namespace twin::robot {

/// Faults of one direction of the link.
using DirectionConfig = rt::DirectionConfig;

/// Longest delay of a message; longer ones count as lost, since a successor would overtake them and
/// they would be dropped on arrival.
inline constexpr Duration kLongestOnTheWay = 255 * kCycle;

/// The link between the robot and the workstation.
struct LinkConfig {
  DirectionConfig state;    ///< robot -> workstation
  DirectionConfig command;  ///< workstation -> robot
  /// INT's own processing: a command counts for cycle k only if it arrived by t_k - d_INT.
  Duration d_INT = std::chrono::microseconds(100);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
