#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"

namespace twin::plant {

/// Red, green, blue, opacity; each in [0, 1].
using Colour = std::array<double, 4>;

/// Pose of a frame in its parent. Quaternion w x y z, unit length.
struct Pose {
  Vector3 p{};
  std::array<double, 4> quat{1, 0, 0, 0};
};

/// Mass properties of one link, in the link's frame.
struct Inertial {
  double mass = 0;
  Vector3 com{};
  Matrix3 I{};  ///< about the centre of mass, axes of the link frame
};

/// Kind of a shape; comments describe its `size`.
enum class ShapeKind {
  kMesh,      ///< scale along x, y, z
  kBox,       ///< half extents
  kCylinder,  ///< radius, half length along z
  kCapsule,   ///< radius, half length along z without the caps
  kSphere,    ///< radius
};

/// One visual or collision shape of a link.
struct Shape {
  ShapeKind kind = ShapeKind::kMesh;
  Vector3 size{1, 1, 1};
  Pose X_LS;                     ///< shape in the link's frame
  std::string mesh_uri;          ///< only for meshes
  std::optional<Colour> colour;  ///< absent: from the mesh file
  bool pad = false;              ///< of a finger: its grip surface
  bool lip = false;              ///< of a suction cup: its sealing edge
};

/// How a link is attached to its parent.
enum class JointKind {
  kFixed,
  kRevolute,    ///< a joint of the arm
  kPrismatic,   ///< a finger
  kContinuous,  ///< a wheel
  kFree,        ///< root of a mobile base, on the world
};

/// Whether the joint has two limits.
[[nodiscard]] constexpr bool HasRange(JointKind kind) noexcept {
  return kind == JointKind::kRevolute || kind == JointKind::kPrismatic;
}

/// One link and the joint that carries it.
struct Link {
  std::string name;
  std::string parent;   ///< empty for the root
  std::string joint;    ///< name of the joint to the parent
  std::string follows;  ///< name of the joint whose position it copies; empty: none
  JointKind joint_kind = JointKind::kFixed;
  Pose X_PL;         ///< link in its parent at zero joint position
  Vector3 axis{};    ///< of the joint, link frame
  double q_min = 0;  ///< rad, m
  double q_max = 0;
  double tau_max = 0;  ///< of the joint's drive, magnitude, Nm, N
  std::optional<Inertial> inertial;
  std::vector<Shape> visual;
  std::vector<Shape> collision;
};

/// A tree of links, parents before their children. Root first.
struct RobotDescription {
  std::string name;
  std::vector<Link> links;

  /// @returns null if no link has that name.
  [[nodiscard]] const Link* Find(const std::string& link) const noexcept;
};

/// Reads a URDF. A collision shape whose name begins with "pad" is a pad, with "lip" a lip.
/// @param text   the document. @param where  its file, for messages.
/// @throws InputError naming file and element: what urdfdom reports, or what is not supported
/// (joints other than fixed, revolute, continuous and prismatic; a
/// <mimic> that scales or shifts).
[[nodiscard]] RobotDescription ParseUrdf(const std::string& text, const std::string& where);

/// Puts `robot` on a base: prepends the base's links and attaches the robot's root to `mount`, a
/// link of the base. @param where  the base's file, for messages. @throws InputError for an unknown
/// mount or a duplicate name.
void PutOnBase(const RobotDescription& base, const std::string& mount, RobotDescription& robot,
               const std::string& where);

/// Mounts `tool` on `robot`: the tool's root names the robot's link that carries it.
/// @param where  the tool's file, for messages. @throws InputError for an unknown mount or a
/// duplicate name.
void Mount(RobotDescription& robot, const RobotDescription& tool, const std::string& where);

/// Replaces every mesh of `robot` by its link's shapes from a primitives file.
///
/// The file (YAML): `unit: m`; `colours`: name to [red, green, blue, opacity]; `links`: link name
/// to a list of shapes, each {shape: capsule | cylinder, from, to, radius} or {shape: sphere, at,
/// radius} or {shape: box, at, half}, with `colour` and, optionally, `use: visual | collision`
/// (default: both). All in the link's frame.
/// @param text  the file's content. @param where  its name, for messages.
/// @throws InputError naming file, line and key.
void UsePrimitives(const std::string& text, const std::string& where, RobotDescription& robot);

}  // namespace twin::plant
