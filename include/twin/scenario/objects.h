#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/plant/scene_object.h"

namespace twin::scenario {

/// A frame in another one.
struct FramePose {
  Vector3 position{};  ///< m
  Vector3 rpy{};       ///< roll, pitch, yaw about the fixed axes x, y, z, rad: R = Rz Ry Rx

  [[nodiscard]] Transform Matrix() const noexcept;
  bool operator==(const FramePose&) const = default;
};

/// Half widths of uniform ranges about an object's values, each >= 0.
struct ObjectSpread {
  Vector3 size{};      ///< m; of a cylinder x counts for its diameter, of a sphere for all
  double mass = 0;     ///< kg
  Vector3 position{};  ///< m
  Vector3 rpy{};       ///< rad
  double friction = 0;
  bool operator==(const ObjectSpread&) const = default;
};

/// A body beside the robot: an object to grasp, or one on which others stand.
///
/// Where it stands: with `on`, in the frame of what is below it, T, whose origin is the middle of
/// the upper face and whose axes are that object's (kGround: the base frame). There its centre is
/// at (x, y, z + h), h half of its height as it is turned: with z = 0 it stands on it. Without
/// `on`, its centre is at `position` in the base frame.
struct ObjectSection {
  std::string name;  ///< letters, digits, '_'
  plant::ObjectShape shape = plant::ObjectShape::kBox;
  Vector3 size{};                ///< as plant::SceneObject::size
  std::optional<double> mass{};  ///< kg; absent: it is fixed to the world
  double friction = 1;           ///< as plant::SceneObject::friction
  std::string on{};              ///< an object before it in the list; kGround; empty: nothing
  FramePose pose{};
  std::optional<std::array<double, 3>> colour{};  ///< red, green, blue, in [0, 1]
  ObjectSpread spread{};  ///< drawn from the scenario's seed, each value by itself
  std::string where{};    ///< where it was read; no part of the comparison
  bool operator==(const ObjectSection& other) const;
};

inline constexpr std::string_view kGround = "ground";  ///< the plane z = 0 of the base frame

/// The objects of a run with this seed: drawn from their ranges, with their poses.
/// @throws InputError naming the object, with file and line where it was read, and what is wrong.
[[nodiscard]] std::vector<plant::SceneObject> ObjectsOf(std::span<const ObjectSection> objects,
                                                        std::uint64_t seed);

/// The same objects without ranges: as ObjectsOf draws them, for other seeds too.
[[nodiscard]] std::vector<ObjectSection> DrawnFrom(std::span<const ObjectSection> objects,
                                                   std::uint64_t seed);

/// T of an object, in the world. @throws InputError of a sphere.
[[nodiscard]] Transform TopOf(const plant::SceneObject& object);

/// Pose of an object that stands on another one.
/// @param W_T_top  T of what is below it. @param pose  position and turn in T, as ObjectSection's.
[[nodiscard]] Transform StandingOn(const Transform& W_T_top, const plant::SceneObject& object,
                                   const FramePose& pose) noexcept;

/// h: half of an object's extent along the z axis of a frame in which it is turned so.
[[nodiscard]] double HalfHeight(const plant::SceneObject& object, const Transform& turned) noexcept;

}  // namespace twin::scenario
