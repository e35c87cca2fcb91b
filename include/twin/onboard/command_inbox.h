#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::onboard {

/// Selects the command that INT executes in a cycle: in the cycle after state k, the newest arrival
/// with message_id = k and arrival <= deadline.
///
/// An older id is late, a newer one invalid: both are dropped. The robot's exact comparison is not
/// public; ours follows the public timing rule (a command that misses its cycle is dropped).
/// Source: FCI protocol 5, "When a command counts as lost".
///
/// Threads: one. Real-time: noexcept, allocates nothing. Holds at most kCapacity commands; a new
/// one replaces the oldest.
class CommandInbox {
 public:
  static constexpr std::size_t kCapacity = 32;

  /// Stores a command that has arrived. @pre arrival times do not decrease.
  void Push(const RobotCommand& command, Time arrival) noexcept TWIN_REALTIME;

  /// Takes everything that arrived by `deadline`; commands that arrived later stay for the next
  /// call.
  /// @param answered_id  id of the last state sent.
  /// @returns the selected command, valid until the next Push, or null.
  [[nodiscard]] const RobotCommand* Select(std::uint64_t answered_id,
                                           Time deadline) noexcept TWIN_REALTIME {
    return Select(answered_id, answered_id, deadline);
  }
  /// The same in an asynchronous motion, whose commands may answer an older state.
  /// @param oldest_id  of the states that count.
  [[nodiscard]] const RobotCommand* Select(std::uint64_t oldest_id, std::uint64_t answered_id,
                                           Time deadline) noexcept TWIN_REALTIME;

  /// Commands dropped between the last two calls of Select(): late, invalid, superseded and
  /// overflown ones together.
  [[nodiscard]] std::uint32_t dropped() const noexcept { return dropped_; }

 private:
  struct Arrived {
    RobotCommand command;
    Time arrival{};
  };
  std::array<Arrived, kCapacity> arrived_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint32_t overflown_ = 0;
  std::uint32_t dropped_ = 0;
};

}  // namespace twin::onboard
