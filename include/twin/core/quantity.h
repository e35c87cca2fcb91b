#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"

namespace twin {

/// Dimension of a quantity in a file; determines the accepted units.
enum class Dimension : std::uint8_t {
  kTime,
  kFrequency,
  kAngle,
  kAngularVelocity,
  kAngularAcceleration,
  kAngularJerk,
  kForce,
  kTorque,
  kTorqueRate,
  kStiffness,
  kLinearStiffness,
  kLinearDamping,
  kAngularDamping,
  kSteepness,
  kIntegralGain,
  kRate,
  kInertia,
  kMass,
  kPressure,
  kLength,
  kVelocity,
  kAcceleration,
  kJerk,
  kPercent,
  kDrift,
};

/// Reads a number with its unit, "80 us" or "-45 deg". The space is optional; micro is u, the micro
/// sign or a small mu.
/// @returns the value in the dimension's base unit: s, Hz, rad, rad/s, rad/s^2, rad/s^3, N, Nm,
/// Nm/s, Nm/rad, N/m, Ns/m, Nms/rad, s/rad, Nm/rad/s, 1/s, kg m^2, kg, Pa, m, m/s, m/s^2, m/s^3,
/// percent or ppm (drift).
/// @throws InputError with the given text and the accepted units. The text names no file: the
/// file's reader prepends the location.
[[nodiscard]] double ParseQuantity(std::string_view text, Dimension dimension);

/// Reads a time to the nearest nanosecond. @throws InputError as ParseQuantity, and for more than a
/// century.
[[nodiscard]] Duration ParseDuration(std::string_view text);

/// @returns the factor from `unit` to the base unit of `dimension`.
/// @throws InputError naming the unit and the accepted ones.
[[nodiscard]] double UnitFactor(std::string_view unit, Dimension dimension);

/// @returns all accepted units.
[[nodiscard]] std::vector<std::string_view> UnitNames(Dimension dimension);

/// @returns the name for messages: "angular velocity".
[[nodiscard]] std::string_view Name(Dimension dimension);

/// @returns the base unit's name.
[[nodiscard]] std::string_view BaseUnit(Dimension dimension);

/// @returns a range in the base unit, for messages: "[0, 1000] Hz".
[[nodiscard]] std::string FormatRange(double least, double most, Dimension dimension);

/// Reads a plain decimal number, all of `text`. @throws InputError when it is not a finite number.
[[nodiscard]] double ParseNumber(std::string_view text);

/// @returns the shortest text from which ParseNumber gives the same double.
[[nodiscard]] std::string FormatNumber(double value);

/// @returns the time in the largest unit that gives an integer: "18320 ms".
[[nodiscard]] std::string FormatDuration(Duration value);

}  // namespace twin
