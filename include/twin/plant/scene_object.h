#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"

namespace twin::plant {

/// What an object is, about its own centre; cylinders stand along their z axis.
enum class ObjectShape : std::uint8_t {
  kBox,
  kCylinder,
  kSphere,
};

/// A solid body beside the robot, beyond what the scene's own file holds: of homogeneous density,
/// its frame in its centre.
struct SceneObject {
  std::string name;  ///< of body, shape and joint; letters, digits, '_'; no other body has it
  ObjectShape shape = ObjectShape::kBox;
  /// Outer dimensions along its own axes, m, each in [0.001, 10]; of a cylinder x = y is the
  /// diameter, of a sphere all three are.
  Vector3 size{0.05, 0.05, 0.05};
  std::optional<double> mass{};  ///< kg, in [0.001, 100]; absent: it is fixed to the world
  Transform X_WB =
      kIdentityTransform;  ///< of its frame in the world; without a mobile base that is O
  double friction = 1;     ///< sliding, in [0, 10]; against fingers, their pads' counts instead
  std::array<double, 4> rgba{0.8, 0.25, 0.2, 1};
  bool operator==(const SceneObject&) const = default;
};

/// @throws InputError naming object, field, value and range; also when two share a name.
void Validate(const std::vector<SceneObject>& objects);

}  // namespace twin::plant
