#include <fmt/format.h>

#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

/// Beyond what any hand does; the hand's own ranges are told in its own words.
constexpr double kMost = 1e6;

hand::Move ReadMove(const YamlNode& node) {
  const YamlMap map = node.Map({"width", "speed"});
  return {.width = map.Require("width").Quantity(Dimension::kLength, -kMost, kMost),
          .speed = map.Require("speed").Quantity(Dimension::kVelocity, -kMost, kMost)};
}

hand::Grasp ReadGrasp(const YamlNode& node) {
  const YamlMap map = node.Map({"width", "speed", "force", "epsilon_inner", "epsilon_outer"});
  hand::Grasp grasp;
  grasp.width = map.Require("width").Quantity(Dimension::kLength, -kMost, kMost);
  grasp.speed = map.Require("speed").Quantity(Dimension::kVelocity, -kMost, kMost);
  grasp.force = map.Require("force").Quantity(Dimension::kForce, -kMost, kMost);
  const auto epsilon = [&map](std::string_view key, double& value) {
    IfGiven(map, key,
            [&](const YamlNode& n) { value = n.Quantity(Dimension::kLength, -kMost, kMost); });
  };
  epsilon("epsilon_inner", grasp.epsilon_inner);
  epsilon("epsilon_outer", grasp.epsilon_outer);
  return grasp;
}

void RequireNoValues(const YamlNode& node) {
  if (!node.IsEmpty()) node.Fail("takes no values; write {}");
}

HandCommand ReadCommand(std::string_view key, const YamlNode& node) {
  if (key == "move") return ReadMove(node);
  if (key == "grasp") return ReadGrasp(node);
  RequireNoValues(node);
  if (key == "stop") return hand::Stop{};
  return hand::Homing{};
}

/// @param previous  time of the command above it.
HandEvent ReadEvent(const YamlNode& node, Duration previous) {
  const YamlMap map = node.Map({"at", "homing", "move", "grasp", "stop"});
  const YamlNode at = map.Require("at");
  HandEvent event;
  event.at = at.Time(Duration::zero(), kDay);
  if (event.at < previous) {
    at.Fail("comes before the command above it; give them in order of time");
  }
  int commands = 0;
  for (const std::string_view key : {"homing", "move", "grasp", "stop"}) {
    IfGiven(map, key, [&](const YamlNode& n) {
      event.command = ReadCommand(key, n);
      ++commands;
      // The largest opening is known to a hand that was homed; the one it is built for counts here.
      if (const auto bad = FindBadValue(event.command, 0)) n.Fail(Describe(*bad));
    });
  }
  if (commands != 1) node.Fail("give exactly one of homing, move, grasp, stop");
  return event;
}

}  // namespace

std::vector<HandEvent> ReadHand(const YamlNode& node) {
  std::vector<HandEvent> events;
  for (const YamlNode& item : node.Items()) {
    events.push_back(ReadEvent(item, events.empty() ? Duration::zero() : events.back().at));
  }
  return events;
}

}  // namespace twin::scenario
