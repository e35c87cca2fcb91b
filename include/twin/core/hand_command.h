#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "twin/core/setting.h"

// What the hand is asked for and what it answers, one struct per request of the Franka Control
// Interface. Source: FCI protocol 5, gripper.
namespace twin::hand {

/// Finds both ends of the fingers' way; afterwards the largest opening is known.
struct Homing {
  bool operator==(const Homing&) const = default;
};

/// Moves the fingers to an opening.
struct Move {
  double width = 0;  ///< m, in [0, largest opening + 1 mm]
  double speed = 0;  ///< of the opening, m/s, > 0; the hand does at most 0.1
  bool operator==(const Move&) const = default;
};

/// Grasps an object, and holds it.
struct Grasp {
  double width = 0;  ///< of the object, m, in [0, largest opening + 1 mm]
  double speed = 0;  ///< as Move
  double force = 0;  ///< each finger presses with it, N, in (0, 140]
  /// The grasp is one when width - epsilon_inner < opening < width + epsilon_outer, m, each >= 0.
  double epsilon_inner = 0.005;
  double epsilon_outer = 0.005;
  bool operator==(const Grasp&) const = default;
};

/// Ends what runs, and presses no more.
struct Stop {
  bool operator==(const Stop&) const = default;
};

}  // namespace twin::hand

namespace twin {

using HandCommand = std::variant<hand::Homing, hand::Move, hand::Grasp, hand::Stop>;

/// How a command ended.
enum class HandResult : std::uint8_t {
  kSuccess,
  kFail,          ///< not possible: a value out of range, or something was in the way
  kUnsuccessful,  ///< a grasp that met nothing, or something of another width
  kAborted,       ///< by Stop, or by a command that came while it ran
};

/// Names one command that was started; zero names none.
using HandTicket = std::uint32_t;

/// What became of a request to start a command.
struct HandStart {
  HandTicket ticket = 0;        ///< zero: refused
  std::optional<BadValue> bad;  ///< what it was refused for; the interface calls that kFail
};

/// What the hand reports.
struct HandState {
  std::uint32_t message_id = 0;   ///< cycles (ms) since the hand was switched on
  double width = 0;               ///< distance between the fingers, m
  double max_width = 0;           ///< as the last homing found it, m; 0 before
  bool is_grasped = false;        ///< an object is held; see onboard::Gripper
  std::uint16_t temperature = 0;  ///< of the drive, degrees Celsius
  bool operator==(const HandState&) const = default;
};

/// The opening the hand is built for, m. Source: FCI protocol 5, gripper (Franka's data sheet).
inline constexpr double kHandStroke = 0.08;

/// How far a commanded width may exceed the largest opening, m: a measured opening is rarely as
/// round as what people ask for.
inline constexpr double kHandWidthTolerance = 1e-3;

/// Looks for the first value that is out of range or not finite.
/// @param max_width  as the hand reports it; 0 (not known): kHandStroke counts.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<BadValue> FindBadValue(const HandCommand& command,
                                                   double max_width) noexcept;

/// "Homing", "Move", "Grasp", "Stop".
[[nodiscard]] std::string_view Name(const HandCommand& command) noexcept;

/// In snake case: "success", ...
[[nodiscard]] std::string_view Name(HandResult result) noexcept;

}  // namespace twin
