#include <algorithm>
#include <array>
#include <memory>

#include "scenario/sections.h"
#include "twin/core/error.h"
#include "twin/model/lab_limits.h"

namespace twin::scenario {

using enum Dimension;

namespace {

constexpr double kMostForce = 1e4;   // N or Nm
constexpr double kFastest = 100;     // m/s or rad/s
constexpr double kMostNormal = 1e3;  // only its direction counts

constexpr std::array<Spelling<model::LimitedPart>, model::kLimitedParts> kPartNames{
    {{"end_effector", model::LimitedPart::kEndEffector},
     {"elbow", model::LimitedPart::kElbow},
     {"hand", model::LimitedPart::kHand}}};

constexpr std::array<Spelling<bool>, 2> kSideNames{{{"inside", true}, {"outside", false}}};

/// One value for all joints, or {unit: rad, values: [7 numbers]}.
Value EachJoint(JointVector& value, Dimension dimension, double most) {
  const auto one = std::make_shared<double>(value[0]);
  Value for_all = Quantity(*one, dimension, 0, most);
  for_all.read = [=, &value, read = for_all.read](const YamlNode& node) {
    read(node);
    value.fill(*one);
  };
  return Either(for_all, Joints(value, dimension), [&value] {
    return std::ranges::all_of(value, [&](double each) { return each == value[0]; });
  });
}

auto Cap(Dimension dimension, double most) {
  return [=](double& cap) { return Quantity(cap, dimension, 0, most); };
}

auto JointCap(Dimension dimension, double most) {
  return [=](JointVector& cap) { return EachJoint(cap, dimension, most); };
}

void DescribeSpeed(Map& map, model::LabLimits& limits) {
  map.Add("joints", Optional(limits.dq_max, JointCap(kAngularVelocity, kFastest)),
          "Largest speed of every joint, or of each.");
  map.Add("end_effector", Optional(limits.v_max, Cap(kVelocity, kFastest)),
          "Largest speed of the end effector's origin.");
  map.Add("rotation", Optional(limits.w_max, Cap(kAngularVelocity, kFastest)),
          "Largest rate of turn of the end effector.");
}

}  // namespace

static void Describe(Map& map, model::LimitBox& box) {
  map.Add("min", Vector(box.low, kLength, -kFarthest, kFarthest), "Lower end along each axis.");
  map.Add("max", Vector(box.high, kLength, -kFarthest, kFarthest), "Upper end along each axis.");
  map.RequireAll();
}

static void Describe(Map& map, model::HalfSpace& half) {
  const auto number = [](double& one) { return Number(one, -kMostNormal, kMostNormal); };
  map.Add("normal", Array(half.normal, number, "takes three numbers: x, y, z"),
          "Points out of the half-space; only its direction counts.");
  map.Add("offset", Quantity(half.offset, kLength, -kFarthest, kFarthest),
          "The plane's distance from the base along the normal.");
  map.RequireAll();
}

static void Describe(Map& map, model::LimitRegion& region) {
  map.Before([&map](const YamlNode& node) {
    if (map.Given("box").has_value() != map.Given("half_space").has_value()) return;
    node.Fail("a region has one shape: give box or half_space");
  });
  map.DescribeOneOf({"box", "half_space"});
  map.Require("name", Text(region.name), "Names the limit in messages.");
  map.Add("what",
          List(region.parts, [](model::LimitedPart& part) { return Choice(part, kPartNames); }),
          "Parts of the robot that it limits.");
  map.Require("keep", Choice(region.keep_inside, kSideNames), "Where they must stay.");
  map.Add("box", Alternative<model::LimitBox>(region.shape), "A box along the axes of the base.");
  map.Add("half_space", Alternative<model::HalfSpace>(region.shape),
          "What lies behind a plane, seen along its normal.");
}

Value LimitsOf(model::LabLimits& limits) {
  const auto describe = [&limits](Map& map) {
    map.Add("regions", ListOf(limits.regions),
            "Regions in the frame of the arm's base; docs/reference/limits.md.")
        .OmitIf(limits.regions.empty());
    map.Add("speed", Section([&limits](Map& of) { DescribeSpeed(of, limits); }), "Caps on speed.");
    map.Add("force", Optional(limits.force_max, Cap(kForce, kMostForce)),
            "Largest external force at the end effector, as the robot estimates it.");
    map.Add("torque", Optional(limits.tau_max, JointCap(kTorque, kMostForce)),
            "Largest external torque of every joint, or of each, as the robot estimates it.");
  };
  return Validated(Section(describe, Style::kBlock), [&limits] { limits.Validate(); });
}

}  // namespace twin::scenario
