#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "twin/core/setting.h"

// Commands to the hand and its answers, one struct per request of the Franka Control Interface.
// Source: FCI protocol 5, gripper.
namespace twin::hand {

/// Finds both end stops of the fingers; this determines the largest opening.
struct Homing {
  bool operator==(const Homing&) const = default;
};

/// Moves the fingers to an opening.
struct Move {
  double width = 0;  ///< m, in [0, largest opening + 1 mm]
  double speed = 0;  ///< of the opening, m/s, > 0; cut to 0.1
  bool operator==(const Move&) const = default;
};

/// Grasps an object and holds it.
struct Grasp {
  double width = 0;  ///< of the object, m, in [0, largest opening + 1 mm]
  double speed = 0;  ///< as in Move
  double force = 0;  ///< of each finger, N, in (0, 140]
  /// A grasp succeeds if width - epsilon_inner < opening < width + epsilon_outer, m, each >= 0.
  double epsilon_inner = 0.005;
  double epsilon_outer = 0.005;
  bool operator==(const Grasp&) const = default;
};

/// Ends the running command and stops pressing.
struct Stop {
  bool operator==(const Stop&) const = default;
};

}  // namespace twin::hand

namespace twin {

using HandCommand = std::variant<hand::Homing, hand::Move, hand::Grasp, hand::Stop>;

/// How a command ended.
enum class HandResult : std::uint8_t {
  kSuccess,
  kFail,          ///< not possible: value out of range, or blocked
  kUnsuccessful,  ///< a grasp without an object, or of one with another width
  kAborted,       ///< by Stop, or by a later command
};

/// Identifies a started command; zero means none.
using HandTicket = std::uint32_t;

/// Result of a request to start a command.
struct HandStart {
  HandTicket ticket = 0;        ///< zero: rejected
  std::optional<BadValue> bad;  ///< reason of a rejection, which FCI reports as kFail
};

/// State of the hand.
struct HandState {
  std::uint32_t message_id = 0;   ///< cycles (ms) since the hand was switched on
  double width = 0;               ///< distance between the fingers, m
  double max_width = 0;           ///< from the last homing, m; 0 before
  bool is_grasped = false;        ///< an object is held; see onboard::Gripper
  std::uint16_t temperature = 0;  ///< of the drive, degrees Celsius
  bool operator==(const HandState&) const = default;
};

/// Nominal opening of the hand, m. Source: FCI protocol 5, gripper (Franka's data sheet).
inline constexpr double kHandStroke = 0.08;

/// How far a commanded width may exceed the largest opening, m, since commands are often rounded
/// above the measured opening.
inline constexpr double kHandWidthTolerance = 1e-3;

/// Finds the first value that is out of range or not finite.
/// @param max_width  reported by the hand; 0 (unknown): kHandStroke applies.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<BadValue> FindBadValue(const HandCommand& command,
                                                   double max_width) noexcept;

/// "Homing", "Move", "Grasp", "Stop".
[[nodiscard]] std::string_view Name(const HandCommand& command) noexcept;

/// In snake case: "success", ...
[[nodiscard]] std::string_view Name(HandResult result) noexcept;

}  // namespace twin
