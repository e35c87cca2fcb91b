#include <numbers>

#include "scenario/section_readers.h"
#include "scenario/trajectory_reader.h"

namespace twin::scenario {
namespace {

constexpr double kFarthest = 10;  // m: beyond any reach
constexpr double kTurn = 2 * std::numbers::pi;

/// What the end effector may do is more than most configurations of the arm can: so that joints
/// stay well inside their own limits, and bear two clocks that drift.
reference::Timing GentlePoses() {
  return {.duration = {}, .velocity_scale = 0.1, .acceleration_scale = 0.03, .jerk_scale = 0.01};
}

PoseStep ReadStep(const YamlNode& node) {
  const YamlMap map = node.Map({"position", "rpy", "by", "turn", "at"});
  PoseStep step;
  step.where = node.Where();
  const auto position = map.Find("position");
  const auto rpy = map.Find("rpy");
  if (position) step.position = position->Vector(Dimension::kLength, -kFarthest, kFarthest);
  if (rpy) step.rpy = rpy->Vector(Dimension::kAngle, -kTurn, kTurn);
  IfGiven(map, "by", [&](const YamlNode& n) {
    if (position) n.Fail("beside position; give one of the two");
    step.by = n.Vector(Dimension::kLength, -kFarthest, kFarthest);
  });
  IfGiven(map, "turn", [&](const YamlNode& n) {
    if (rpy) n.Fail("beside rpy; give one of the two");
    step.turn = n.Vector(Dimension::kAngle, -kTurn, kTurn);
  });
  IfGiven(map, "at", [&](const YamlNode& n) { step.at = n.Time(Duration::zero(), kDay); });
  return step;
}

}  // namespace

void ReadPoses(const YamlNode& node, MotionSection& motion) {
  const YamlMap map = node.Map(
      {"start", "duration", "velocity_scale", "acceleration_scale", "jerk_scale", "waypoints"});
  const YamlNode start = map.Require("start");
  motion.waypoints = {{.q = start.JointQuantity(Dimension::kAngle), .where = start.Where()}};
  motion.timing = GentlePoses();
  ReadTiming(map, motion.timing);
  for (const YamlNode& item : map.Require("waypoints").Items()) {
    motion.poses.push_back(ReadStep(item));
  }
  if (motion.poses.empty()) node.Fail("has no waypoints; give at least one pose to go to");
}

}  // namespace twin::scenario
