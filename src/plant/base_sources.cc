#include "plant/model_sources.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "plant/base_joints.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

void RequirePrimitive(const RobotDescription& base, const std::string& where) {
  const auto is_mesh = [](const Shape& shape) { return shape.kind == ShapeKind::kMesh; };
  for (const Link& link : base.links) {
    if (std::ranges::none_of(link.visual, is_mesh) &&
        std::ranges::none_of(link.collision, is_mesh)) {
      continue;
    }
    throw InputError(
        fmt::format("{}: link '{}' has a mesh; a base is drawn and touched in boxes, "
                    "cylinders and spheres",
                    where, link.name));
  }
}

/// A wheel is a cylinder that rotates about its axis, attached to the base's root.
bool IsWheel(const Link& link, const std::string& root) {
  return link.parent == root && link.joint_kind == JointKind::kContinuous &&
         link.axis == Vector3{0, 1, 0} && link.collision.size() == 1 &&
         link.collision.front().kind == ShapeKind::kCylinder &&
         link.collision.front().X_LS.p == Vector3{};
}

/// @returns the height of the root's frame above the floor.
double RequireWheels(const RobotDescription& base, const std::string& where) {
  const std::string& root = base.links.front().name;
  double height = 0;
  for (const char* name : kWheels) {
    const Link* wheel = base.Find(name);
    if (wheel == nullptr || !IsWheel(*wheel, root)) {
      throw InputError(fmt::format(
          "{}: base '{}' needs a wheel '{}': a link on '{}' by a continuous joint about y, that "
          "touches with one cylinder about the joint's axis",
          where, base.name, name, root));
    }
    height = wheel->collision.front().size[0] - wheel->X_PL.p[2];
  }
  for (const Link& link : base.links) {
    const bool is_wheel = std::ranges::find(kWheels, link.name) != kWheels.end();
    if (is_wheel || link.joint_kind == JointKind::kFixed) continue;
    throw InputError(fmt::format("{}: joint '{}' of base '{}' moves; only its four wheels may",
                                 where, link.joint, base.name));
  }
  return height;
}

}  // namespace

RobotDescription ReadBase(const std::filesystem::path& urdf, ContentHash& hash) {
  const std::string text = ReadFileBytes(urdf, "the mobile base's URDF");
  hash.Add(text);
  RobotDescription base = ParseUrdf(text, urdf.string());
  RequirePrimitive(base, urdf.string());
  const double height = RequireWheels(base, urdf.string());
  Link& root = base.links.front();
  root.joint_kind = JointKind::kFree;
  root.joint = root.name;
  root.X_PL.p[2] = height;
  return base;
}

}  // namespace twin::plant
