#include <string>

#include <fmt/format.h>

#include "twin/scenario/names.h"
#include "scenario/quoted.h"
#include "scenario/section_writers.h"
#include "twin/core/quantity.h"

namespace twin::scenario {
namespace {

std::string VectorText(const Vector3& v, Dimension dimension) {
  const std::string_view unit = BaseUnit(dimension);
  return fmt::format("[{0} {3}, {1} {3}, {2} {3}]", FormatNumber(v[0]), FormatNumber(v[1]),
                     FormatNumber(v[2]), unit);
}

std::string SpreadText(const ObjectSpread& spread) {
  std::string text = fmt::format(
      "{{size: {}, position: {}, rpy: {}, friction: {}",
      VectorText(spread.size, Dimension::kLength), VectorText(spread.position, Dimension::kLength),
      VectorText(spread.rpy, Dimension::kAngle), FormatNumber(spread.friction));
  if (spread.mass > 0) text += fmt::format(", mass: {} kg", FormatNumber(spread.mass));
  return text + "}";
}

std::string ObjectText(const ObjectSection& object) {
  std::string text = fmt::format("  - {{name: {}, shape: {}, size: {}, ", Quoted(object.name),
                                 NameOf(kObjectShapeNames, object.shape),
                                 VectorText(object.size, Dimension::kLength));
  if (object.mass) text += fmt::format("mass: {} kg, ", FormatNumber(*object.mass));
  if (!object.on.empty()) text += fmt::format("on: {}, ", Quoted(object.on));
  if (object.colour) {
    text += fmt::format("colour: [{}, {}, {}], ", FormatNumber((*object.colour)[0]),
                        FormatNumber((*object.colour)[1]), FormatNumber((*object.colour)[2]));
  }
  return text + fmt::format("friction: {}, position: {}, rpy: {}, spread: {}}}\n",
                            FormatNumber(object.friction),
                            VectorText(object.pose.position, Dimension::kLength),
                            VectorText(object.pose.rpy, Dimension::kAngle),
                            SpreadText(object.spread));
}

}  // namespace

std::string ObjectsText(const std::vector<ObjectSection>& objects) {
  if (objects.empty()) return {};
  std::string text = "objects:\n";
  for (const ObjectSection& object : objects) text += ObjectText(object);
  return text;
}

}  // namespace twin::scenario
