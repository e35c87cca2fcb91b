#include "scenario/trajectory_reader.h"

#include <fmt/format.h>

#include "scenario/section_readers.h"
#include "twin/core/error.h"
#include "twin/reference/trajectory_file.h"

namespace twin::scenario {
namespace {

reference::Waypoint ReadWaypoint(const YamlNode& node, double unit) {
  const YamlMap map = node.Map({"q", "at", "stop"});
  reference::Waypoint point;
  point.q = map.Require("q").JointNumbers(unit);
  if (auto at = map.Find("at")) point.at = at->Time(Duration::zero(), kDay);
  if (auto stop = map.Find("stop")) point.stop = stop->Bool();
  point.where = node.Where();
  return point;
}

void ReadTrajectoryMap(const YamlNode& node, MotionSection& motion) {
  const YamlMap map = node.Map(
      {"unit", "duration", "velocity_scale", "acceleration_scale", "jerk_scale", "waypoints"});
  const YamlNode unit = map.Require("unit");
  double factor = 1;
  try {
    factor = UnitFactor(unit.Text(), Dimension::kAngle);
  } catch (const InputError& error) {
    unit.Fail(error.what());
  }
  ReadTiming(map, motion.timing);
  for (const YamlNode& item : map.Require("waypoints").Items()) {
    motion.waypoints.push_back(ReadWaypoint(item, factor));
  }
}

}  // namespace

void ReadTiming(const YamlMap& map, reference::Timing& timing) {
  if (auto value = map.Find("duration")) {
    timing.duration = value->Time(Duration(1), kDay);
  }
  if (auto value = map.Find("velocity_scale")) {
    timing.velocity_scale = value->Number(1e-6, 1);
  }
  if (auto value = map.Find("acceleration_scale")) {
    timing.acceleration_scale = value->Number(1e-6, 1);
  }
  if (auto value = map.Find("jerk_scale")) timing.jerk_scale = value->Number(1e-6, 1);
}

void ReadTrajectory(const YamlNode& node, const std::filesystem::path& folder,
                    MotionSection& motion) {
  if (!node.IsScalar()) {
    ReadTrajectoryMap(node, motion);
    return;
  }
  const std::filesystem::path file = folder / node.Text();
  if (file.extension() == ".csv") {
    motion.waypoints = reference::ReadWaypointsCsv(file);
  } else if (file.extension() == ".yaml") {
    ReadTrajectoryMap(YamlNode::ParseFile(file.string()), motion);
  } else {
    node.Fail(fmt::format("\"{}\" is no trajectory file; its name must end in .yaml or .csv",
                          node.Text()));
  }
}

}  // namespace twin::scenario
