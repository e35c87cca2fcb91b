#include <limits>

#include "scenario/section_readers.h"
#include "scenario/trajectory_reader.h"

namespace twin::scenario {
namespace {

/// random, {q: {unit, values}} or {pose: {position, rpy}}.
std::variant<RandomGoal, JointVector, FramePose> ReadGoal(const YamlNode& node) {
  if (node.IsScalar()) {
    if (node.Text() != "random") {
      node.Fail("a goal is random, {q: {unit: rad, values: [...]}} or {pose: {position, rpy}}");
    }
    return RandomGoal{};
  }
  const auto [key, goal] = node.OneOf({"q", "pose"});
  if (key == "q") return goal.JointQuantity(Dimension::kAngle);
  const YamlMap pose = goal.Map({"position", "rpy"});
  (void)pose.Require("position");
  (void)pose.Require("rpy");
  return ReadFrame(goal);
}

}  // namespace

void ReadPlan(const YamlNode& node, MotionSection& motion) {
  const YamlMap map = node.Map({"goal", "seed", "budget", "clearance", "stretch", "velocity_scale",
                                "acceleration_scale", "jerk_scale"});
  constexpr std::uint64_t kMostChecks = 1'000'000'000'000;
  PlanSection& plan = motion.plan.emplace();
  plan.where = node.Where();
  plan.goal = ReadGoal(map.Require("goal"));
  IfGiven(map, "seed", [&](const YamlNode& n) {
    plan.seed = n.Integer(0, std::numeric_limits<std::uint64_t>::max());
  });
  IfGiven(map, "budget", [&](const YamlNode& n) { plan.budget = n.Integer(1, kMostChecks); });
  IfGiven(map, "clearance",
          [&](const YamlNode& n) { plan.clearance = n.Quantity(Dimension::kLength, 1e-3, 0.1); });
  IfGiven(map, "stretch", [&](const YamlNode& n) { plan.stretch = n.Number(1, 1000); });
  for (const auto& [key, share] : {std::pair{"velocity_scale", &motion.timing.velocity_scale},
                                   {"acceleration_scale", &motion.timing.acceleration_scale},
                                   {"jerk_scale", &motion.timing.jerk_scale}}) {
    IfGiven(map, key, [&share = *share](const YamlNode& n) { share = n.Number(1e-3, 1); });
  }
}

}  // namespace twin::scenario
