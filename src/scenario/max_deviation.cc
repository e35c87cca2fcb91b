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

/// How many times softer than as delivered, in its softest direction; at least 1.
template <std::size_t N>
double Softness(const std::array<double, N>& delivered, const std::array<double, N>& stiffness) {
  double softness = 1;
  for (std::size_t i = 0; i < N; ++i) {
    softness = std::max(softness, stiffness[i] > 0 ? delivered[i] / stiffness[i] : kUnlimited);
  }
  return softness;
}

double Default(const Scenario& scenario, control::CommandInterface interface,
               ControllerMode impedance) {
  if (interface == control::CommandInterface::kTorque || !scenario.perturbations.empty()) {
    return kUnlimited;
  }
  const OnboardSection& onboard = scenario.onboard;
  return kDefault * (impedance == ControllerMode::kCartesianImpedance
                         ? Softness(setting::CartesianImpedance().K_x, onboard.K_x)
                         : Softness(setting::JointImpedance().K_theta, onboard.K_theta));
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

DeviationLimit LimitOf(const Scenario& scenario, control::CommandInterface interface,
                       ControllerMode impedance) {
  const double otherwise = Default(scenario, interface, impedance);
  const MaxDeviation& max = scenario.max_deviation;
  if (interface == control::CommandInterface::kCartesianPose) {
    return {.position = max.position.value_or(otherwise), .angle = max.angle.value_or(otherwise)};
  }
  return {.joints = max.joints.value_or(otherwise)};
}

std::string FollowedMotion::Excess() const {
  std::string text;
  const auto add = [&text](double value, double most, std::string_view unit, std::string where) {
    if (value <= most) return;
    text += fmt::format("{}{:.4g} {} {}, above the limit of {:.4g} {}", text.empty() ? "" : "; ",
                        value * 1e3, unit, where, most * 1e3, unit);
  };
  const auto seconds = [](Time at) { return ToSeconds(at.time_since_epoch()); };
  if (const auto& joints = deviation.joints) {
    add(joints->largest, limit.joints, "mrad",
        fmt::format("(joint {}, at {:.3f} s)", joints->joint + 1, seconds(joints->at)));
  }
  if (const auto& pose = deviation.pose) {
    add(pose->position, limit.position, "mm",
        fmt::format("(position, at {:.3f} s)", seconds(pose->position_at)));
    add(pose->angle, limit.angle, "mrad",
        fmt::format("(angle, at {:.3f} s)", seconds(pose->angle_at)));
  }
  return text;
}

}  // namespace twin::scenario
