#include <array>
#include <numbers>

#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

constexpr double kFarthest = 10;   // m
constexpr double kHeaviest = 100;  // kg
constexpr double kRoughest = 10;
constexpr double kTurn = 2 * std::numbers::pi;

void ReadSpread(const YamlNode& node, ObjectSpread& spread) {
  const YamlMap map = node.Map({"size", "mass", "position", "rpy", "friction"});
  IfGiven(map, "size",
          [&](const YamlNode& n) { spread.size = n.Vector(Dimension::kLength, 0, kFarthest); });
  IfGiven(map, "mass",
          [&](const YamlNode& n) { spread.mass = n.Quantity(Dimension::kMass, 0, kHeaviest); });
  IfGiven(map, "position",
          [&](const YamlNode& n) { spread.position = n.Vector(Dimension::kLength, 0, kFarthest); });
  IfGiven(map, "rpy",
          [&](const YamlNode& n) { spread.rpy = n.Vector(Dimension::kAngle, 0, kTurn); });
  IfGiven(map, "friction", [&](const YamlNode& n) { spread.friction = n.Number(0, kRoughest); });
}

std::array<double, 3> ReadColour(const YamlNode& node) {
  const std::vector<YamlNode> items = node.Items();
  std::array<double, 3> colour{};
  if (items.size() != colour.size()) node.Fail("takes three numbers: red, green, blue");
  for (std::size_t i = 0; i < colour.size(); ++i) colour[i] = items[i].Number(0, 1);
  return colour;
}

ObjectSection ReadObject(const YamlNode& node) {
  const YamlMap map = node.Map(
      {"name", "shape", "size", "mass", "friction", "on", "position", "rpy", "colour", "spread"});
  ObjectSection object;
  object.where = node.Where();
  object.name = map.Require("name").Text();
  object.shape = ReadChoice(map.Require("shape"), kObjectShapeNames);
  object.size = map.Require("size").Vector(Dimension::kLength, 0, kFarthest);
  IfGiven(map, "mass",
          [&](const YamlNode& n) { object.mass = n.Quantity(Dimension::kMass, 0, kHeaviest); });
  IfGiven(map, "friction", [&](const YamlNode& n) { object.friction = n.Number(0, kRoughest); });
  IfGiven(map, "on", [&](const YamlNode& n) { object.on = n.Text(); });
  IfGiven(map, "position", [&](const YamlNode& n) {
    object.pose.position = n.Vector(Dimension::kLength, -kFarthest, kFarthest);
  });
  IfGiven(map, "rpy",
          [&](const YamlNode& n) { object.pose.rpy = n.Vector(Dimension::kAngle, -kTurn, kTurn); });
  IfGiven(map, "colour", [&](const YamlNode& n) { object.colour = ReadColour(n); });
  IfGiven(map, "spread", [&](const YamlNode& n) { ReadSpread(n, object.spread); });
  return object;
}

}  // namespace

std::vector<ObjectSection> ReadObjects(const YamlNode& node) {
  std::vector<ObjectSection> objects;
  for (const YamlNode& item : node.Items()) objects.push_back(ReadObject(item));
  return objects;
}

}  // namespace twin::scenario
