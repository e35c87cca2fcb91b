#include "twin/core/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin {
namespace {

struct Unit {
  std::string_view name;
  double factor;  ///< to the dimension's base unit
};

constexpr double kDegree = std::numbers::pi / 180;

constexpr std::array kTimeUnits{Unit{"ns", 1e-9}, Unit{"us", 1e-6}, Unit{"ms", 1e-3}, Unit{"s", 1},
                                Unit{"min", 60}};
/// The two letters for micro, U+00B5 and U+03BC, in UTF-8.
constexpr std::array<std::string_view, 2> kMicroSeconds{"\u00b5s", "\u03bcs"};
constexpr std::array kFrequencyUnits{Unit{"Hz", 1}, Unit{"kHz", 1e3}};
constexpr std::array kAngleUnits{Unit{"rad", 1}, Unit{"mrad", 1e-3}, Unit{"deg", kDegree}};
constexpr std::array kAngularVelocityUnits{Unit{"rad/s", 1}, Unit{"deg/s", kDegree}};
constexpr std::array kAngularAccelerationUnits{Unit{"rad/s^2", 1}, Unit{"deg/s^2", kDegree}};
constexpr std::array kAngularJerkUnits{Unit{"rad/s^3", 1}, Unit{"deg/s^3", kDegree}};
constexpr std::array kForceUnits{Unit{"N", 1}};
constexpr std::array kTorqueUnits{Unit{"Nm", 1}};
constexpr std::array kTorqueRateUnits{Unit{"Nm/s", 1}};
constexpr std::array kStiffnessUnits{Unit{"Nm/rad", 1}};
constexpr std::array kLinearStiffnessUnits{Unit{"N/m", 1}};
constexpr std::array kLinearDampingUnits{Unit{"Ns/m", 1}};
constexpr std::array kAngularDampingUnits{Unit{"Nms/rad", 1}, Unit{"Nm s/rad", 1}};
constexpr std::array kSteepnessUnits{Unit{"s/rad", 1}};
constexpr std::array kIntegralGainUnits{Unit{"Nm/rad/s", 1}};
constexpr std::array kRateUnits{Unit{"1/s", 1}};
constexpr std::array kInertiaUnits{Unit{"kg m^2", 1}};
constexpr std::array kMassUnits{Unit{"kg", 1}, Unit{"g", 1e-3}};
constexpr std::array kPressureUnits{Unit{"Pa", 1}, Unit{"kPa", 1e3}, Unit{"mbar", 100},
                                    Unit{"bar", 1e5}};
constexpr std::array kLengthUnits{Unit{"m", 1}, Unit{"mm", 1e-3}};
constexpr std::array kVelocityUnits{Unit{"m/s", 1}, Unit{"mm/s", 1e-3}};
constexpr std::array kAccelerationUnits{Unit{"m/s^2", 1}};
constexpr std::array kJerkUnits{Unit{"m/s^3", 1}};
constexpr std::array kPercentUnits{Unit{"%", 1}};
constexpr std::array kDriftUnits{Unit{"ppm", 1}};

struct DimensionInfo {
  std::string_view name;     ///< with article
  std::string_view example;  ///< of the notation
  std::span<const Unit> units;
};

DimensionInfo Info(Dimension dimension) {
  switch (dimension) {
    case Dimension::kTime: return {"a time", "500 us", kTimeUnits};
    case Dimension::kFrequency: return {"a frequency", "1000 Hz", kFrequencyUnits};
    case Dimension::kAngle: return {"an angle", "45 deg", kAngleUnits};
    case Dimension::kAngularVelocity:
      return {"an angular velocity", "0.5 rad/s", kAngularVelocityUnits};
    case Dimension::kAngularAcceleration:
      return {"an angular acceleration", "2 rad/s^2", kAngularAccelerationUnits};
    case Dimension::kAngularJerk: return {"an angular jerk", "50 rad/s^3", kAngularJerkUnits};
    case Dimension::kForce: return {"a force", "30 N", kForceUnits};
    case Dimension::kTorque: return {"a torque", "0.1 Nm", kTorqueUnits};
    case Dimension::kTorqueRate: return {"a torque rate", "1000 Nm/s", kTorqueRateUnits};
    case Dimension::kStiffness: return {"a stiffness", "3000 Nm/rad", kStiffnessUnits};
    case Dimension::kLinearStiffness: return {"a stiffness", "1000 N/m", kLinearStiffnessUnits};
    case Dimension::kLinearDamping: return {"a damping", "30 Ns/m", kLinearDampingUnits};
    case Dimension::kAngularDamping: return {"a damping", "10 Nms/rad", kAngularDampingUnits};
    case Dimension::kSteepness: return {"a steepness", "100 s/rad", kSteepnessUnits};
    case Dimension::kIntegralGain: return {"an integral gain", "5 Nm/rad/s", kIntegralGainUnits};
    case Dimension::kRate: return {"a rate", "10 1/s", kRateUnits};
    case Dimension::kInertia: return {"a moment of inertia", "0.2 kg m^2", kInertiaUnits};
    case Dimension::kMass: return {"a mass", "0.73 kg", kMassUnits};
    case Dimension::kPressure: return {"a pressure", "600 mbar", kPressureUnits};
    case Dimension::kLength: return {"a length", "1.5 m", kLengthUnits};
    case Dimension::kVelocity: return {"a velocity", "1.5 m/s", kVelocityUnits};
    case Dimension::kAcceleration: return {"an acceleration", "10 m/s^2", kAccelerationUnits};
    case Dimension::kJerk: return {"a jerk", "5000 m/s^3", kJerkUnits};
    case Dimension::kPercent: return {"a percentage", "0.1 %", kPercentUnits};
    case Dimension::kDrift: return {"a clock drift", "20 ppm", kDriftUnits};
  }
  return {"a quantity", "", {}};
}

std::string UnitList(const DimensionInfo& info) {
  std::string list;
  for (const Unit& unit : info.units) {
    if (!list.empty()) list += ", ";
    list += unit.name;
  }
  return list;
}

/// Reads the longest prefix that is a decimal number. @returns its length, or 0.
std::size_t ReadNumber(std::string_view text, double& value) {
  const std::size_t sign = text.starts_with('+') ? 1 : 0;
  const char* begin = text.data() + sign;
  const char* end = text.data() + text.size();
  // from_chars also accepts "inf" and "nan", which are not quantities.
  const char* digits = begin != end && *begin == '-' && sign == 0 ? begin + 1 : begin;
  if (digits == end || !((*digits >= '0' && *digits <= '9') || *digits == '.')) return 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error == std::errc::result_out_of_range) value = HUGE_VAL;
  if (error == std::errc::invalid_argument) return 0;
  return static_cast<std::size_t>(stop - text.data());
}

std::string_view Trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

double UnitFactor(std::string_view unit, Dimension dimension) {
  const DimensionInfo info = Info(dimension);
  if (std::ranges::find(kMicroSeconds, unit) != kMicroSeconds.end()) unit = "us";
  const auto found = std::ranges::find(info.units, unit, &Unit::name);
  if (found != info.units.end()) return found->factor;
  throw InputError(fmt::format("unit \"{}\" does not fit {}; write it like \"{}\" (units: {})",
                               unit, info.name, info.example, UnitList(info)));
}

double ParseQuantity(std::string_view text, Dimension dimension) {
  const DimensionInfo info = Info(dimension);
  const std::string_view trimmed = Trim(text);
  double value = 0;
  const std::size_t length = ReadNumber(trimmed, value);
  if (length == 0) {
    throw InputError(fmt::format("\"{}\" is not {}; write it like \"{}\" (units: {})", text,
                                 info.name, info.example, UnitList(info)));
  }
  const std::string_view unit = Trim(trimmed.substr(length));
  if (unit.empty()) {
    throw InputError(fmt::format("\"{}\" has no unit; {} is written like \"{}\" (units: {})", text,
                                 info.name, info.example, UnitList(info)));
  }
  value *= UnitFactor(unit, dimension);
  if (!std::isfinite(value)) {
    throw InputError(fmt::format("\"{}\" is too large; give a finite value", text));
  }
  return value;
}

Duration ParseDuration(std::string_view text) {
  constexpr double kCenturySeconds = 3.2e9;
  const double seconds = ParseQuantity(text, Dimension::kTime);
  if (std::abs(seconds) <= kCenturySeconds) return FromSeconds(seconds);
  throw InputError(fmt::format("\"{}\" is more than a century; give a shorter time", text));
}

std::vector<std::string_view> UnitNames(Dimension dimension) {
  std::vector<std::string_view> names;
  for (const Unit& unit : Info(dimension).units) names.push_back(unit.name);
  if (dimension == Dimension::kTime)
    names.insert(names.end(), kMicroSeconds.begin(), kMicroSeconds.end());
  return names;
}

std::string_view Name(Dimension dimension) {
  const std::string_view with_article = Info(dimension).name;
  return with_article.substr(with_article.find(' ') + 1);
}

std::string_view BaseUnit(Dimension dimension) {
  for (const Unit& unit : Info(dimension).units) {
    if (unit.factor == 1) return unit.name;
  }
  return {};
}

std::string FormatRange(double least, double most, Dimension dimension) {
  return fmt::format("[{}, {}] {}", least, most, BaseUnit(dimension));
}

double ParseNumber(std::string_view text) {
  double value = 0;
  const std::size_t length = ReadNumber(text, value);
  if (length != 0 && length == text.size() && std::isfinite(value)) return value;
  throw InputError(fmt::format("\"{}\" is not a finite number", text));
}

std::string FormatNumber(double value) {
  return fmt::format("{}", value);
}

std::string FormatDuration(Duration value) {
  struct Step {
    std::int64_t ns;
    const char* unit;
  };
  constexpr std::array kSteps{Step{1'000'000'000, "s"}, Step{1'000'000, "ms"}, Step{1'000, "us"}};
  for (const Step& step : kSteps) {
    if (value.count() % step.ns == 0) {
      return fmt::format("{} {}", value.count() / step.ns, step.unit);
    }
  }
  return fmt::format("{} ns", value.count());
}

}  // namespace twin
