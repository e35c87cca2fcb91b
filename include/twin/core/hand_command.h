#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "twin/core/setting.h"

// Commands to the device on the flange and its answers, one struct per request of the Franka
// Control Interface. Homing, Move and Grasp are the Franka Hand's, Vacuum and DropOff the cobot
// pump's, Stop is both's. Source: FCI protocol 5, gripper and vacuum gripper.
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

/// Ends the running command and stops pressing, or sucking.
struct Stop {
  bool operator==(const Stop&) const = default;
};

/// Sucks an object on and holds it; see onboard::VacuumPump.
struct Vacuum {
  std::uint8_t vacuum = 0;      ///< set point, 10 mbar, > 0; cut to the pump's 750 mbar
  std::uint8_t profile = 0;     ///< of the pump's settings, in [0, 3]
  std::int64_t timeout_ms = 0;  ///< to hold an object, >= 0
  bool operator==(const Vacuum&) const = default;
};

/// Lets the object go.
struct DropOff {
  std::int64_t timeout_ms = 0;  ///< to be rid of the vacuum, >= 0
  bool operator==(const DropOff&) const = default;
};

}  // namespace twin::hand

namespace twin {

using HandCommand =
    std::variant<hand::Homing, hand::Move, hand::Grasp, hand::Stop, hand::Vacuum, hand::DropOff>;

/// What takes the commands.
enum class HandDevice : std::uint8_t {
  kFrankaHand,  ///< two fingers
  kCobotPump,   ///< the vacuum gripper
};

/// How a command ended.
enum class HandResult : std::uint8_t {
  kSuccess,
  kFail,          ///< not possible: value out of range, or blocked
  kUnsuccessful,  ///< a grasp without an object, or of one with another width; no vacuum in time
  kAborted,       ///< by Stop, or by a later command
};

/// Identifies a started command; zero means none.
using HandTicket = std::uint32_t;

/// Result of a request to start a command.
struct HandStart {
  HandTicket ticket = 0;        ///< zero: rejected
  std::optional<BadValue> bad;  ///< reason of a rejection, which FCI reports as kFail
};

/// Traffic light of the cobot pump.
enum class PumpStatus : std::uint8_t {
  kGreen,   ///< works
  kYellow,  ///< works, with a warning
  kOrange,  ///< works, with a severe warning
  kRed,     ///< does not work
};

/// State of the cobot pump. What the flags mean: onboard::VacuumPump.
struct VacuumState {
  std::uint32_t message_id = 0;   ///< cycles (ms) since the pump was switched on
  bool in_control_range = false;  ///< the vacuum is at its set point
  bool part_detached = false;     ///< the object that was held is gone
  bool part_present = false;      ///< an object is held
  PumpStatus device_status = PumpStatus::kGreen;
  std::int32_t actual_power = 0;  ///< of the pump, percent
  std::int32_t vacuum = 0;        ///< below the air's pressure, mbar
  bool operator==(const VacuumState&) const = default;
};

/// State of the hand.
struct HandState {
  std::uint32_t message_id = 0;  ///< cycles (ms) since the hand was switched on
  double width = 0;              ///< distance between the fingers, m; 0 of a pump
  double max_width = 0;          ///< from the last homing, m; 0 before, and of a pump
  bool is_grasped = false;       ///< an object is held; see onboard::Gripper; a pump's part_present
  std::uint16_t temperature = 0;      ///< of the drive, degrees Celsius; 0 of a pump
  std::optional<VacuumState> pump{};  ///< of a cobot pump
  bool operator==(const HandState&) const = default;
};

/// Nominal opening of the hand, m. Source: FCI protocol 5, gripper (Franka's data sheet).
inline constexpr double kHandStroke = 0.08;

/// How far a commanded width may exceed the largest opening, m, since commands are often rounded
/// above the measured opening.
inline constexpr double kHandWidthTolerance = 1e-3;

/// Finds the first value that is out of range or not finite, and a command that the device has not.
/// @param max_width  reported by the hand; 0 (unknown): kHandStroke applies.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<BadValue> FindBadValue(
    const HandCommand& command, double max_width,
    HandDevice device = HandDevice::kFrankaHand) noexcept;

/// "Homing", "Move", "Grasp", "Stop", "Vacuum", "Drop Off".
[[nodiscard]] std::string_view Name(const HandCommand& command) noexcept;

/// In snake case: "success", ...
[[nodiscard]] std::string_view Name(HandResult result) noexcept;

/// "green", ...
[[nodiscard]] std::string_view Name(PumpStatus status) noexcept;

}  // namespace twin
