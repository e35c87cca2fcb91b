#include "scenario/section_readers.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

constexpr double kMostForce = 1e4;  // N or Nm
constexpr double kFarthest = 100;   // m
constexpr std::uint64_t kMostMotions = 1'000'000;

Vector3 ReadPoint(const YamlNode& node) {
  return node.Vector(Dimension::kLength, -kFarthest, kFarthest);
}

/// What pushes and springs have in common.
template <typename Kind>
void ReadWhereAndWhen(const YamlMap& map, Kind& what) {
  what.body = map.Require("body").Text();
  what.begin = map.Require("begin").Time(Duration::zero(), kDay);
  IfGiven(map, "motion", [&](const YamlNode& n) {
    what.motion = static_cast<std::uint32_t>(n.Integer(1, kMostMotions));
  });
  IfGiven(map, "duration",
          [&](const YamlNode& n) { what.duration = n.Time(Duration::zero(), kDay); });
  IfGiven(map, "point", [&](const YamlNode& n) { what.point = ReadPoint(n); });
}

plant::Push ReadPush(const YamlNode& node) {
  const YamlMap map = node.Map(
      {"body", "begin", "motion", "duration", "rise", "force", "torque", "point", "frame"});
  plant::Push push;
  ReadWhereAndWhen(map, push);
  IfGiven(map, "rise", [&](const YamlNode& n) { push.rise = n.Time(Duration::zero(), kDay); });
  IfGiven(map, "force", [&](const YamlNode& n) {
    push.force = n.Vector(Dimension::kForce, -kMostForce, kMostForce);
  });
  IfGiven(map, "torque", [&](const YamlNode& n) {
    push.torque = n.Vector(Dimension::kTorque, -kMostForce, kMostForce);
  });
  if (!map.Find("force") && !map.Find("torque")) node.Fail("give a force, a torque or both");
  IfGiven(map, "frame", [&](const YamlNode& n) { push.frame = ReadChoice(n, kForceFrameNames); });
  return push;
}

plant::HandSpring ReadSpring(const YamlNode& node) {
  const YamlMap map = node.Map({"body", "begin", "motion", "duration", "point", "from", "by",
                                "stiffness", "damping", "largest_force"});
  plant::HandSpring spring;
  ReadWhereAndWhen(map, spring);
  IfGiven(map, "from", [&](const YamlNode& n) { spring.from = ReadPoint(n); });
  IfGiven(map, "by", [&](const YamlNode& n) { spring.by = ReadPoint(n); });
  IfGiven(map, "stiffness", [&](const YamlNode& n) {
    spring.stiffness = n.Quantity(Dimension::kLinearStiffness, 0, 2e4);
  });
  IfGiven(map, "damping", [&](const YamlNode& n) {
    spring.damping = n.Quantity(Dimension::kLinearDamping, 0, 500);
  });
  IfGiven(map, "largest_force", [&](const YamlNode& n) {
    spring.largest_force = n.Quantity(Dimension::kForce, 0, kMostForce);
  });
  return spring;
}

plant::Perturbation ReadPerturbation(const YamlNode& node) {
  const auto [kind, what] = node.OneOf({"push", "spring"});
  plant::Perturbation perturbation;
  if (kind == "push") {
    perturbation = ReadPush(what);
  } else {
    perturbation = ReadSpring(what);
  }
  try {
    plant::Validate(perturbation);
  } catch (const InputError& error) {
    what.Fail(error.what());
  }
  return perturbation;
}

}  // namespace

std::vector<plant::Perturbation> ReadPerturbations(const YamlNode& node) {
  std::vector<plant::Perturbation> perturbations;
  for (const YamlNode& item : node.Items()) perturbations.push_back(ReadPerturbation(item));
  return perturbations;
}

}  // namespace twin::scenario
