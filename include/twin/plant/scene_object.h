#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"

namespace twin::plant {

/// Shape of an object, about its centre; a cylinder's axis is z.
enum class ObjectShape : std::uint8_t {
  kBox,
  kCylinder,
  kSphere,
};

/// A solid body near the robot, in addition to the scene's file: of homogeneous density, with its
/// frame at its centre.
struct SceneObject {
  std::string name;  ///< of body, shape and joint; letters, digits, '_'; unique
  ObjectShape shape = ObjectShape::kBox;
  /// Outer dimensions along its own axes, m, each in [0.001, 10]; the diameter is x = y for a
  /// cylinder and x = y = z for a sphere.
  Vector3 size{0.05, 0.05, 0.05};
  std::optional<double> mass{};  ///< kg, in [0.001, 100]; absent: fixed to the world
  Transform X_WB =
      kIdentityTransform;  ///< of its frame in the world; without a mobile base that is O
  double friction = 1;     ///< sliding, in [0, 10]; against fingers, the pads' applies
  std::array<double, 4> rgba{0.8, 0.25, 0.2, 1};
  bool operator==(const SceneObject&) const = default;
};

/// @throws InputError naming object, field, value and range; also for duplicate names.
void Validate(const std::vector<SceneObject>& objects);

}  // namespace twin::plant
