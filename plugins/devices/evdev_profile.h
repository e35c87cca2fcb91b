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

// Linux's description of an input device, and the meaning of its axes and keys here. Codes and
// values are those of linux/input-event-codes.h.
namespace twin::devices {

/// Range of an absolute axis.
struct AxisRange {
  int minimum = 0;
  int maximum = 0;
  int flat = 0;  ///< half width of the dead zone
};

/// Axes and keys of a device.
struct EvdevCapabilities {
  std::string name;
  std::map<std::uint16_t, AxisRange> abs;
  std::set<std::uint16_t> rel;
  std::set<std::uint16_t> keys;
  bool can_rumble = false;
};

/// Usable kinds of devices.
enum class EvdevKind : std::uint8_t {
  kSpaceMouse,  ///< six axes that return to the centre; no gamepad buttons
  kGamepad,     ///< at least one stick, and a gamepad's buttons
};

/// @returns nullopt for unsuitable devices: a keyboard, a mouse.
[[nodiscard]] std::optional<EvdevKind> KindOf(const EvdevCapabilities& capabilities);

/// Source of one of the operator's axes.
struct AxisSource {
  enum class Kind : std::uint8_t { kNone, kAbsolute, kRelative };
  Kind kind = Kind::kNone;
  std::uint16_t code = 0;
  double sign = 1;
};

/// Meaning of a device's axes and keys.
struct EvdevProfile {
  /// A key and the sample counter that it increments.
  struct Key {
    std::uint16_t code = 0;
    std::uint32_t teleop::OperatorSample::*presses = nullptr;
  };
  std::array<AxisSource, 6> axes;  ///< in the order of OperatorSample::axes
  std::vector<Key> keys;
  std::optional<std::uint16_t> clutch;  ///< re-centres while held
  /// A device with two buttons: {left, right}, with combined meanings (two_buttons.h).
  std::optional<std::array<std::uint16_t, 2>> two_buttons;
};

/// The default profile for a kind of device, limited to its axes and keys.
///
/// A SpaceMouse's axes are right, towards the operator, down, in that order, and about them. A
/// gamepad's left stick moves forward and sideways, its right stick up and about the vertical; the
/// directional pad rotates about the other two axes.
[[nodiscard]] EvdevProfile UsualProfile(EvdevKind kind, const EvdevCapabilities& capabilities);

/// Overrides from the parameters axes.x, axes.y ... axes.rz and buttons.mode ... buttons.clutch:
/// names of linux/input-event-codes.h, such as "-ABS_RY" and "BTN_SOUTH", or "none".
/// @throws InputError for an unknown name, and for one that the device lacks.
void ApplyParameters(control::ParameterReader& parameters, const EvdevCapabilities& capabilities,
                     EvdevProfile& profile);

}  // namespace twin::devices
