#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "twin/control/parameters.h"
#include "twin/teleop/operator_sample.h"

// What Linux tells of an input device, and what its axes and keys mean here. Codes and values are
// those of linux/input-event-codes.h.
namespace twin::devices {

/// Of an absolute axis.
struct AxisRange {
  int minimum = 0;
  int maximum = 0;
  int flat = 0;  ///< what counts as the centre, to either side
};

/// What a device has.
struct EvdevCapabilities {
  std::string name;
  std::map<std::uint16_t, AxisRange> abs;
  std::set<std::uint16_t> rel;
  std::set<std::uint16_t> keys;
  bool can_rumble = false;
};

/// What is led with.
enum class EvdevKind : std::uint8_t {
  kSpaceMouse,  ///< six axes that all return to the middle, and no buttons of a gamepad
  kGamepad,     ///< at least a stick, and a gamepad's buttons
};

/// @returns nothing when nobody could lead with it: a keyboard, a mouse.
[[nodiscard]] std::optional<EvdevKind> KindOf(const EvdevCapabilities& capabilities);

/// Where an axis of the operator comes from.
struct AxisSource {
  enum class Kind : std::uint8_t { kNone, kAbsolute, kRelative };
  Kind kind = Kind::kNone;
  std::uint16_t code = 0;
  double sign = 1;
};

/// What the axes and keys of a device mean.
struct EvdevProfile {
  /// A key, and the counter of the sample that it drives.
  struct Key {
    std::uint16_t code = 0;
    std::uint32_t teleop::OperatorSample::*presses = nullptr;
  };
  std::array<AxisSource, 6> axes;  ///< of OperatorSample::axes, in their order
  std::vector<Key> keys;
  std::optional<std::uint16_t> clutch;  ///< re-centres while it is held
  /// A device with two buttons: {left, right}, which mean more than one thing (two_buttons.h).
  std::optional<std::array<std::uint16_t, 2>> two_buttons;
};

/// The usual meaning of a device of this kind, where the device has the axes and keys.
///
/// A SpaceMouse's axes are right, towards the operator, down, in that order, and about them; of a
/// gamepad the left stick moves ahead and aside, the right one up and about the vertical, the cross
/// turns about the other two.
[[nodiscard]] EvdevProfile UsualProfile(EvdevKind kind, const EvdevCapabilities& capabilities);

/// What the parameters axes.x, axes.y ... axes.rz and buttons.mode ... buttons.clutch say instead:
/// names of linux/input-event-codes.h, such as "-ABS_RY" and "BTN_SOUTH", or "none".
/// @throws InputError for a name that is none, and for what the device does not have.
void ApplyParameters(control::ParameterReader& parameters, const EvdevCapabilities& capabilities,
                     EvdevProfile& profile);

}  // namespace twin::devices
