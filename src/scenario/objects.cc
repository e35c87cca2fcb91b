#include "twin/scenario/objects.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/transform.h"

namespace twin::scenario {
namespace {

using plant::ObjectShape;
using plant::SceneObject;

constexpr std::array<double, 4> kWood{0.72, 0.66, 0.58, 1};

/// The draws of one object, by number: another one for every value, whatever is spread.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t object)
      : random_(seed, RandomStream::kObjects), object_(object) {}

  [[nodiscard]] double About(double value, double spread, std::uint32_t number) const noexcept {
    if (spread == 0) return value;
    return value + spread * (2 * random_.Uniform(object_, number) - 1);
  }
  [[nodiscard]] Vector3 About(const Vector3& value, const Vector3& spread,
                              std::uint32_t number) const noexcept {
    return {About(value[0], spread[0], number), About(value[1], spread[1], number + 1),
            About(value[2], spread[2], number + 2)};
  }

 private:
  Random random_;
  std::uint64_t object_;
};

Transform Moved(const Transform& X, double x, double y, double z) {
  Transform by = kIdentityTransform;
  by[12] = x;
  by[13] = y;
  by[14] = z;
  return model::Multiply(X, by);
}

Transform BelowOf(const ObjectSection& section, const std::vector<SceneObject>& before) {
  if (section.on == kGround) return kIdentityTransform;
  const auto below = std::ranges::find(before, section.on, &SceneObject::name);
  if (below != before.end()) return TopOf(*below);
  throw InputError(
      fmt::format("on: \"{}\" is no object that is listed before it; name one, or say {}",
                  section.on, kGround));
}

/// The section with drawn values in place of its ranges.
ObjectSection Drawn(const ObjectSection& section, const Draws& draws) {
  const ObjectSpread& spread = section.spread;
  ObjectSection drawn = section;
  drawn.spread = {};
  drawn.size = draws.About(section.size, spread.size, 0);
  if (section.shape != ObjectShape::kBox) drawn.size[1] = drawn.size[0];
  if (section.shape == ObjectShape::kSphere) drawn.size[2] = drawn.size[0];
  if (section.mass) drawn.mass = draws.About(*section.mass, spread.mass, 3);
  drawn.friction = draws.About(section.friction, spread.friction, 4);
  drawn.pose = {draws.About(section.pose.position, spread.position, 5),
                draws.About(section.pose.rpy, spread.rpy, 8)};
  return drawn;
}

/// @param drawn  without ranges.
SceneObject Placed(const ObjectSection& drawn, const std::vector<SceneObject>& before) {
  SceneObject object{.name = drawn.name,
                     .shape = drawn.shape,
                     .size = drawn.size,
                     .mass = drawn.mass,
                     .friction = drawn.friction};
  object.X_WB = drawn.on.empty() ? drawn.pose.Matrix()
                                 : StandingOn(BelowOf(drawn, before), object, drawn.pose);
  if (drawn.colour) {
    std::ranges::copy(*drawn.colour, object.rgba.begin());
  } else if (!drawn.mass) {
    object.rgba = kWood;
  }
  return object;
}

/// Only what moves has a mass, and the diameters of what is round are one.
void RequireSection(const ObjectSection& section) {
  if (!section.mass && section.spread.mass > 0) {
    throw InputError("spread.mass: it is fixed to the world, and has no mass; leave it out");
  }
  const bool is_round = section.shape != ObjectShape::kBox;
  const bool is_ball = section.shape == ObjectShape::kSphere;
  if (is_round &&
      (section.size[0] != section.size[1] || (is_ball && section.size[0] != section.size[2]))) {
    throw InputError(is_ball ? "size: a sphere's are equal, its diameter"
                             : "size: a cylinder's x and y are equal, its diameter");
  }
}

}  // namespace

bool ObjectSection::operator==(const ObjectSection& other) const {
  return name == other.name && shape == other.shape && size == other.size && mass == other.mass &&
         friction == other.friction && on == other.on && pose == other.pose &&
         colour == other.colour && spread == other.spread;
}

Transform StandingOn(const Transform& W_T_top, const SceneObject& object,
                     const FramePose& pose) noexcept {
  const Transform turned = pose.Matrix();
  return model::Multiply(Moved(W_T_top, 0, 0, HalfHeight(object, turned)), turned);
}

double HalfHeight(const SceneObject& object, const Transform& turned) noexcept {
  const double x = std::abs(turned[2]);
  const double y = std::abs(turned[6]);
  const double z = std::abs(turned[10]);
  const Vector3& size = object.size;
  switch (object.shape) {
    case ObjectShape::kBox: return (x * size[0] + y * size[1] + z * size[2]) / 2;
    case ObjectShape::kCylinder: return (std::hypot(x, y) * size[0] + z * size[2]) / 2;
    case ObjectShape::kSphere: return size[0] / 2;
  }
  return 0;
}

Transform TopOf(const SceneObject& object) {
  if (object.shape == ObjectShape::kSphere) {
    throw InputError(fmt::format("on: {} is a sphere, on which nothing stands", object.name));
  }
  return Moved(object.X_WB, 0, 0, object.size[2] / 2);
}

std::vector<ObjectSection> DrawnFrom(std::span<const ObjectSection> objects, std::uint64_t seed) {
  std::vector<ObjectSection> drawn;
  for (const ObjectSection& section : objects) {
    drawn.push_back(Drawn(section, Draws(seed, drawn.size())));
  }
  return drawn;
}

std::vector<SceneObject> ObjectsOf(std::span<const ObjectSection> objects, std::uint64_t seed) {
  std::vector<SceneObject> placed;
  for (const ObjectSection& section : objects) {
    try {
      RequireSection(section);
      placed.push_back(Placed(Drawn(section, Draws(seed, placed.size())), placed));
      plant::Validate(placed);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}objects: {}: {}",
                                   section.where.empty() ? "" : section.where + ": ", section.name,
                                   error.what()));
    }
  }
  return placed;
}

}  // namespace twin::scenario
