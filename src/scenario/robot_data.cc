#include "twin/scenario/robot_data.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/yaml_node.h"
#include "twin/core/error.h"
#include "twin/model/transform.h"

namespace twin::scenario {
namespace {

/// The names of the robots there are: folders with a limits.yaml.
std::vector<std::string> RobotNames(const std::filesystem::path& robots) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(robots, error)) {
    if (std::filesystem::exists(entry.path() / "limits.yaml", error)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

/// Turned by `angle` about z, then moved by `z` along it.
Transform TurnedAndRaised(double angle, double z) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, z, 1};
}

JointVector LoadRotorInertia(const std::filesystem::path& file) {
  const YamlMap map = YamlNode::ParseFile(file.string()).Map({"robot", "rotor_inertia"});
  const YamlNode node = map.Require("rotor_inertia");
  const JointVector inertia = node.JointQuantity(Dimension::kInertia);
  for (const double value : inertia) {
    if (value < 0)
      node.Fail(fmt::format("{} kg m^2 is out of range; it must not be negative", value));
  }
  return inertia;
}

void ReadEndEffector(const std::filesystem::path& file, RobotData& robot) {
  const YamlMap map =
      YamlNode::ParseFile(file.string()).Map({"robot", "mass", "F_x_Cee", "I_ee", "F_T_NE"});
  robot.end_effector.m = map.Require("mass").Quantity(Dimension::kMass, 0, 100);
  robot.end_effector.F_x_C = map.Require("F_x_Cee").Vector(Dimension::kLength, -1, 1);
  const Vector3 inertia = map.Require("I_ee").Vector(Dimension::kInertia, 0, 10);
  for (std::size_t i = 0; i < inertia.size(); ++i) robot.end_effector.I[4 * i] = inertia[i];
  const YamlMap tip = map.Require("F_T_NE").Map({"angle", "z"});
  robot.F_T_NE = TurnedAndRaised(tip.Require("angle").Quantity(Dimension::kAngle, -7, 7),
                                 tip.Require("z").Quantity(Dimension::kLength, -10, 10));
}

/// The dimensions of a component's velocity, acceleration and jerk.
struct Derivatives {
  Dimension dp, ddp, dddp;
};
constexpr Derivatives kLinear{Dimension::kVelocity, Dimension::kAcceleration, Dimension::kJerk};
constexpr Derivatives kAngular{Dimension::kAngularVelocity, Dimension::kAngularAcceleration,
                               Dimension::kAngularJerk};

CartesianBound ReadBound(const YamlNode& node, const Derivatives& dimensions) {
  constexpr double kLeast = 1e-9;
  constexpr double kMost = 1e9;
  const YamlMap map = node.Map({"dp_max", "ddp_max", "dddp_max"});
  return {map.Require("dp_max").UnitAndValue(dimensions.dp, kLeast, kMost),
          map.Require("ddp_max").UnitAndValue(dimensions.ddp, kLeast, kMost),
          map.Require("dddp_max").UnitAndValue(dimensions.dddp, kLeast, kMost)};
}

/// A section of a limits.yaml.
YamlNode LimitsSection(const std::filesystem::path& file, std::string_view section) {
  return YamlNode::ParseFile(file.string()).Map({"robot", "joints", "cartesian"}).Require(section);
}

}  // namespace

Transform RobotData::F_T_EE(const FramePose& NE_T_EE) const {
  return model::Multiply(F_T_NE, NE_T_EE.Matrix());
}

JointLimits LoadJointLimits(const std::filesystem::path& file) {
  const YamlMap joints =
      LimitsSection(file, "joints")
          .Map({"q_min", "q_max", "dq_max", "ddq_max", "dddq_max", "tau_max", "dtau_max"});
  const auto read = [&](std::string_view key, Dimension dimension) {
    return joints.Require(key).JointQuantity(dimension);
  };
  JointLimits limits;
  limits.q_min = read("q_min", Dimension::kAngle);
  limits.q_max = read("q_max", Dimension::kAngle);
  limits.dq_max = read("dq_max", Dimension::kAngularVelocity);
  limits.ddq_max = read("ddq_max", Dimension::kAngularAcceleration);
  limits.dddq_max = read("dddq_max", Dimension::kAngularJerk);
  limits.tau_max = read("tau_max", Dimension::kTorque);
  limits.dtau_max = read("dtau_max", Dimension::kTorqueRate);
  try {
    limits.Validate();
  } catch (const InputError& error) {
    joints.node().Fail(error.what());
  }
  return limits;
}

CartesianLimits LoadCartesianLimits(const std::filesystem::path& file) {
  const YamlMap map = LimitsSection(file, "cartesian").Map({"translation", "rotation", "elbow"});
  return {ReadBound(map.Require("translation"), kLinear),
          ReadBound(map.Require("rotation"), kAngular), ReadBound(map.Require("elbow"), kAngular)};
}

RobotData LoadRobotData(const std::filesystem::path& models, std::string_view name,
                        plant::HandKind hand) {
  const std::filesystem::path robots = models / "robots";
  const std::vector<std::string> names = RobotNames(robots);
  if (std::ranges::find(names, name) == names.end()) {
    throw InputError(fmt::format("robot.model: \"{}\" is unknown; {} has: {}", name,
                                 robots.string(), fmt::join(names, ", ")));
  }
  RobotData robot;
  robot.name = name;
  robot.urdf = robots / name / (robot.name + ".urdf");
  robot.limits = LoadJointLimits(robots / name / "limits.yaml");
  robot.cartesian = LoadCartesianLimits(robots / name / "limits.yaml");
  robot.rotor_inertia = LoadRotorInertia(robots / name / "drives.yaml");
  if (hand == plant::HandKind::kFrankaHand) {
    ReadEndEffector(robots / "hand" / "end_effector.yaml", robot);
  }
  return robot;
}

}  // namespace twin::scenario
