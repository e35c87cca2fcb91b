#include "twin/scenario/max_deviation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "scenario/max_deviation.h"
#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
/// Of a robot of the stiffness it is delivered with: 20 mrad, or mm.
constexpr double kDefault = 0.02;

/// A limit, or "off".
double ReadLimit(const YamlNode& node, Dimension dimension, double most) {
  if (node.IsScalar() && node.Text() == "off") return kUnlimited;
  return node.Quantity(dimension, 1e-9, most);
}

std::string LimitText(double limit, Dimension dimension) {
  return limit == kUnlimited ? "off" : FormatNumber(limit) + " " + std::string(BaseUnit(dimension));
}

}  // namespace

MaxDeviation ReadMaxDeviation(const YamlNode& node, const Scenario& scenario) {
  if (node.IsScalar()) {
    if (node.Text() == "off") return {kUnlimited, kUnlimited, kUnlimited};
    node.Fail("is neither a map with limits nor off");
  }
  const YamlMap map = node.Map({"joints", "position", "angle"});
  MaxDeviation max;
  IfGiven(map, "joints",
          [&](const YamlNode& n) { max.joints = ReadLimit(n, Dimension::kAngle, 10); });
  IfGiven(map, "position",
          [&](const YamlNode& n) { max.position = ReadLimit(n, Dimension::kLength, 10); });
  IfGiven(map, "angle",
          [&](const YamlNode& n) { max.angle = ReadLimit(n, Dimension::kAngle, 10); });
  if (scenario.application) return max;
  const control::CommandInterface interface = scenario.motion.interface;
  const bool of_poses = interface == control::CommandInterface::kCartesianPose;
  if (of_poses ? max.joints.has_value() : max.position || max.angle) {
    node.Fail(fmt::format("motion.interface is {}, whose motions are judged by {}",
                          NameOf(kInterfaceNames, interface),
                          of_poses ? "position and angle" : "joints"));
  }
  return max;
}

std::string MaxDeviationText(const MaxDeviation& max) {
  std::string text;
  const auto add = [&text](std::string_view key, const std::optional<double>& limit,
                           Dimension dimension) {
    if (!limit) return;
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key, LimitText(*limit, dimension));
  };
  add("joints", max.joints, Dimension::kAngle);
  add("position", max.position, Dimension::kLength);
  add("angle", max.angle, Dimension::kAngle);
  if (max == MaxDeviation{kUnlimited, kUnlimited, kUnlimited})
    text = "off";
  else if (!text.empty())
    text = "{" + text + "}";
  return text.empty() ? text : "max_deviation: " + text + "\n";
}

}  // namespace twin::scenario
