#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"

namespace twin {

/// What a quantity in a file measures; decides which units it may be written in.
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
  kIntegralGain,
  kRate,
  kInertia,
  kMass,
  kLength,
  kVelocity,
  kAcceleration,
  kJerk,
  kPercent,
  kDrift,
};

/// Reads a number with its unit, "80 us" or "-45 deg"; the space may be left out, and a micro may
/// be written as a u, as the micro sign or as a small mu.
/// @returns the value in the dimension's base unit: s, Hz, rad, rad/s, rad/s^2, rad/s^3, N, Nm,
/// Nm/s, Nm/rad, N/m, Ns/m, Nms/rad, Nm/rad/s, 1/s, kg m^2, kg, m, m/s, m/s^2, m/s^3, percent or
/// ppm (drift).
/// @throws InputError saying what was given and which units are accepted. The text names no file:
/// the reader of the file puts its own place in front.
[[nodiscard]] double ParseQuantity(std::string_view text, Dimension dimension);

/// Reads a time to the nearest nanosecond. @throws InputError as ParseQuantity, and when it is more
/// than a century.
[[nodiscard]] Duration ParseDuration(std::string_view text);

/// @returns the factor from `unit` to the base unit of `dimension`.
/// @throws InputError naming the unit and the accepted ones.
[[nodiscard]] double UnitFactor(std::string_view unit, Dimension dimension);

/// @returns all units it may be written in.
[[nodiscard]] std::vector<std::string_view> UnitNames(Dimension dimension);

/// @returns what it is, for people: "angular velocity".
[[nodiscard]] std::string_view Name(Dimension dimension);

/// @returns the base unit's name.
[[nodiscard]] std::string_view BaseUnit(Dimension dimension);

/// @returns a range in the base unit, for messages: "[0, 1000] Hz".
[[nodiscard]] std::string FormatRange(double least, double most, Dimension dimension);

/// Reads a plain decimal number in full. @throws InputError when `text` is not one, or is not
/// finite.
[[nodiscard]] double ParseNumber(std::string_view text);

/// @returns the shortest text from which ParseNumber gives the same double.
[[nodiscard]] std::string FormatNumber(double value);

/// @returns the time in the largest unit that gives a whole number: "18320 ms".
[[nodiscard]] std::string FormatDuration(Duration value);

}  // namespace twin
