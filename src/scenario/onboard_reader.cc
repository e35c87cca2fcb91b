#include <algorithm>
#include <numbers>

#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

using setting::CollisionBehavior;

constexpr double kMostThreshold = 1e6;  // N or Nm
constexpr double kMostLength = 10;      // m
constexpr double kMostInertia = 100;    // kg m^2

/// One quantity for all three axes, or [x, y, z].
Vector3 ReadAxes(const YamlNode& node, Dimension dimension, double least, double most) {
  if (!node.IsScalar()) return node.Vector(dimension, least, most);
  Vector3 axes;
  axes.fill(node.Quantity(dimension, least, most));
  return axes;
}

void Put(const Vector3& part, std::size_t at, Vector6& whole) {
  std::ranges::copy(part, whole.begin() + static_cast<std::ptrdiff_t>(at));
}

void ReadCartesianStiffness(const YamlNode& node, Vector6& K_x) {
  const YamlMap map = node.Map({"translation", "rotation"});
  IfGiven(map, "translation", [&](const YamlNode& n) {
    Put(ReadAxes(n, Dimension::kLinearStiffness, 10, 3000), 0, K_x);
  });
  IfGiven(map, "rotation",
          [&](const YamlNode& n) { Put(ReadAxes(n, Dimension::kStiffness, 1, 300), 3, K_x); });
}

void ReadForces(const YamlNode& node, Vector6& forces) {
  const YamlMap map = node.Map({"force", "moment"});
  IfGiven(map, "force", [&](const YamlNode& n) {
    Put(ReadAxes(n, Dimension::kForce, 0, kMostThreshold), 0, forces);
  });
  IfGiven(map, "moment", [&](const YamlNode& n) {
    Put(ReadAxes(n, Dimension::kTorque, 0, kMostThreshold), 3, forces);
  });
}

/// "off", or thresholds; those of a key without suffix are of both sets.
CollisionBehavior ReadCollisionBehavior(const YamlNode& node) {
  if (node.IsScalar() && node.Text() == "off") return NoCollisionBehavior();
  CollisionBehavior b;
  const YamlMap map = node.Map({"lower_torque", "upper_torque", "lower_force", "upper_force",
                                "lower_torque_acc", "upper_torque_acc", "lower_torque_nominal",
                                "upper_torque_nominal", "lower_force_acc", "upper_force_acc",
                                "lower_force_nominal", "upper_force_nominal"});
  const auto torque = [&map](std::string_view key, JointVector& values) {
    IfGiven(map, key, [&](const YamlNode& n) { values = n.JointQuantity(Dimension::kTorque); });
  };
  const auto force = [&map](std::string_view key, Vector6& values) {
    IfGiven(map, key, [&](const YamlNode& n) { ReadForces(n, values); });
  };
  torque("lower_torque", b.lower_torque_acc);
  torque("upper_torque", b.upper_torque_acc);
  force("lower_force", b.lower_force_acc);
  force("upper_force", b.upper_force_acc);
  b.lower_torque_nominal = b.lower_torque_acc;
  b.upper_torque_nominal = b.upper_torque_acc;
  b.lower_force_nominal = b.lower_force_acc;
  b.upper_force_nominal = b.upper_force_acc;
  torque("lower_torque_acc", b.lower_torque_acc);
  torque("upper_torque_acc", b.upper_torque_acc);
  torque("lower_torque_nominal", b.lower_torque_nominal);
  torque("upper_torque_nominal", b.upper_torque_nominal);
  force("lower_force_acc", b.lower_force_acc);
  force("upper_force_acc", b.upper_force_acc);
  force("lower_force_nominal", b.lower_force_nominal);
  force("upper_force_nominal", b.upper_force_nominal);
  RequireValid(node, b);
  return b;
}

}  // namespace

FramePose ReadFrame(const YamlNode& node) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const YamlMap map = node.Map({"position", "rpy"});
  FramePose pose;
  IfGiven(map, "position", [&](const YamlNode& n) {
    pose.position = n.Vector(Dimension::kLength, -kMostLength, kMostLength);
  });
  IfGiven(map, "rpy",
          [&](const YamlNode& n) { pose.rpy = n.Vector(Dimension::kAngle, -kTurn, kTurn); });
  return pose;
}

namespace {

setting::GuidingMode ReadGuidingMode(const YamlNode& node) {
  static constexpr std::array<Spelling<std::size_t>, 6> kAxes{
      {{"x", 0}, {"y", 1}, {"z", 2}, {"R", 3}, {"P", 4}, {"Y", 5}}};
  const YamlMap map = node.Map({"axes", "elbow"});
  setting::GuidingMode mode;
  IfGiven(map, "axes", [&](const YamlNode& n) {
    mode.axes = {};
    for (const YamlNode& axis : n.Items()) mode.axes.at(ReadChoice(axis, kAxes)) = true;
  });
  IfGiven(map, "elbow", [&](const YamlNode& n) { mode.elbow = n.Bool(); });
  return mode;
}

setting::Filters ReadFilters(const YamlNode& node) {
  const YamlMap map = node.Map({"joint_position", "joint_velocity", "cartesian_position",
                                "cartesian_velocity", "controller"});
  setting::Filters filters;
  const auto read = [&map](std::string_view key, double& cutoff) {
    IfGiven(map, key, [&](const YamlNode& n) { cutoff = ReadCutoff(n); });
  };
  read("joint_position", filters.joint_position_hz);
  read("joint_velocity", filters.joint_velocity_hz);
  read("cartesian_position", filters.cartesian_position_hz);
  read("cartesian_velocity", filters.cartesian_velocity_hz);
  read("controller", filters.controller_hz);
  return filters;
}

void ReadSettings(const YamlMap& map, OnboardSection& onboard) {
  IfGiven(map, "K_theta", [&](const YamlNode& n) {
    onboard.K_theta = n.JointQuantity(Dimension::kStiffness);
    RequireValid(n, setting::JointImpedance{onboard.K_theta});
  });
  IfGiven(map, "K_x", [&](const YamlNode& n) { ReadCartesianStiffness(n, onboard.K_x); });
  IfGiven(map, "collision_behavior",
          [&](const YamlNode& n) { onboard.collision_behavior = ReadCollisionBehavior(n); });
  IfGiven(map, "load", [&](const YamlNode& n) { onboard.load = ReadLoad(n); });
  IfGiven(map, "EE_T_K", [&](const YamlNode& n) { onboard.EE_T_K = ReadFrame(n); });
  IfGiven(map, "NE_T_EE", [&](const YamlNode& n) { onboard.NE_T_EE = ReadFrame(n); });
  IfGiven(map, "guiding_mode",
          [&](const YamlNode& n) { onboard.guiding_mode = ReadGuidingMode(n); });
  IfGiven(map, "filters", [&](const YamlNode& n) { onboard.filters = ReadFilters(n); });
}

}  // namespace

void RequireValid(const YamlNode& node, const Setting& setting) {
  if (const auto bad = FindBadValue(setting)) node.Fail(Describe(*bad));
}

double ReadCutoff(const YamlNode& node) {
  if (node.IsScalar() && node.Text() == "off") return kLowPassOff;
  return node.Quantity(Dimension::kFrequency, 1, kLowPassOff);
}

setting::Load ReadLoad(const YamlNode& node) {
  const YamlMap map = node.Map({"mass", "position", "inertia", "products_of_inertia"});
  setting::Load load;
  load.m_load = map.Require("mass").Quantity(Dimension::kMass, 0, 100);
  IfGiven(map, "position", [&](const YamlNode& n) {
    load.F_x_Cload = n.Vector(Dimension::kLength, -kMostLength, kMostLength);
  });
  IfGiven(map, "inertia", [&](const YamlNode& n) {
    const Vector3 I = n.Vector(Dimension::kInertia, 0, kMostInertia);
    for (std::size_t i = 0; i < I.size(); ++i) load.I_load[4 * i] = I[i];
  });
  IfGiven(map, "products_of_inertia", [&](const YamlNode& n) {
    const auto [xy, xz, yz] = n.Vector(Dimension::kInertia, -kMostInertia, kMostInertia);
    Matrix3& I = load.I_load;
    I = {I[0], xy, xz, xy, I[4], yz, xz, yz, I[8]};
  });
  RequireValid(node, load);
  return load;
}

void ReadOnboard(const YamlNode& node, OnboardSection& onboard) {
  const YamlMap map =
      node.Map({"K_theta", "K_x", "collision_behavior", "load", "EE_T_K", "NE_T_EE", "guiding_mode",
                "filters", "damping_ratio", "abort_after_lost", "friction_compensation"});
  ReadSettings(map, onboard);
  IfGiven(map, "damping_ratio",
          [&](const YamlNode& n) { onboard.damping_ratio = n.Number(1e-3, 2); });
  IfGiven(map, "abort_after_lost", [&](const YamlNode& n) {
    onboard.abort_after_lost = static_cast<std::uint32_t>(n.Integer(1, 1'000'000));
  });
  IfGiven(map, "friction_compensation",
          [&](const YamlNode& n) { onboard.friction_compensation = n.Number(0, 1); });
}

}  // namespace twin::scenario
