#include <numbers>

#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

constexpr double kFar = 100;                    // m
constexpr double kTurn = 2 * std::numbers::pi;  // rad
constexpr double kFast = 100;                   // m/s, rad/s: any base cuts it
constexpr Duration kShortest = kCycle;

void ReadStart(const YamlNode& node, BasePose& start) {
  const YamlMap map = node.Map({"x", "y", "yaw"});
  IfGiven(map, "x",
          [&](const YamlNode& n) { start.x = n.Quantity(Dimension::kLength, -kFar, kFar); });
  IfGiven(map, "y",
          [&](const YamlNode& n) { start.y = n.Quantity(Dimension::kLength, -kFar, kFar); });
  IfGiven(map, "yaw",
          [&](const YamlNode& n) { start.yaw = n.Quantity(Dimension::kAngle, -kTurn, kTurn); });
}

/// @param previous  end of the event above it.
DriveEvent ReadDriveEvent(const YamlNode& node, Duration previous) {
  const YamlMap map = node.Map({"at", "for", "v", "w"});
  const YamlNode at = map.Require("at");
  DriveEvent event;
  event.at = at.Time(Duration::zero(), kDay);
  event.span = map.Require("for").Time(kShortest, kDay);
  if (event.at < previous) {
    at.Fail("comes before the end of the drive above it; give them one after the other");
  }
  IfGiven(map, "v", [&](const YamlNode& n) {
    event.twist.v = n.Quantity(Dimension::kVelocity, -kFast, kFast);
  });
  IfGiven(map, "w", [&](const YamlNode& n) {
    event.twist.w = n.Quantity(Dimension::kAngularVelocity, -kFast, kFast);
  });
  return event;
}

}  // namespace

void ReadBase(const YamlNode& node, Scenario& scenario) {
  BaseSection& base = scenario.base.emplace();
  const YamlMap map = node.Map({"model", "start", "drive"});
  IfGiven(map, "model", [&](const YamlNode& n) { base.model = ReadName(n, scenario.places.base); });
  IfGiven(map, "start", [&](const YamlNode& n) { ReadStart(n, base.start); });
  IfGiven(map, "drive", [&](const YamlNode& n) {
    Duration end{};
    for (const YamlNode& item : n.Items()) {
      base.drive.push_back(ReadDriveEvent(item, end));
      end = base.drive.back().at + base.drive.back().span;
    }
  });
}

}  // namespace twin::scenario
