#include "plant/model_sources.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include "plant/base_joints.h"
#include "plant/file_bytes.h"
#include "plant/robot_description.h"
#include "plant/scene_objects.h"
#include "plant/suction.h"
#include "plant/thickness.h"
#include "twin/core/error.h"
#include "twin/plant/mjcf_files.h"

namespace twin::plant {
namespace {

/// Part of every key: increment when the composition changes.
constexpr std::string_view kComposition = "panda-twin composition 4";

constexpr std::string_view kPlainScene = R"(<mujoco>
  <worldbody>
    <light pos="0 0 3" directional="true"/>
    <geom name="floor" type="plane" size="3 3 0.1" rgba="0.7 0.7 0.7 1"/>
  </worldbody>
</mujoco>
)";

/// Body name of MujocoPlantOptions::load.
constexpr std::string_view kLoadBody = "load";
constexpr const char* kLoadText = "the load on the flange";

constexpr std::string_view kPackageScheme = "package://";

/// @param options  for the mesh package. @param folder  of the URDF.
std::filesystem::path ResolveMesh(const std::string& uri, const MujocoPlantOptions& options,
                                  const std::filesystem::path& folder) {
  if (!uri.starts_with(kPackageScheme)) return folder / uri;
  const std::size_t slash = uri.find('/', kPackageScheme.size());
  if (slash == std::string::npos) throw InputError(fmt::format("'{}' names no file", uri));
  return options.mesh_package / uri.substr(slash + 1);
}

bool NamesMeshes(const RobotDescription& robot) {
  const auto is_mesh = [](const Shape& shape) { return shape.kind == ShapeKind::kMesh; };
  return std::ranges::any_of(robot.links, [&](const Link& link) {
    return std::ranges::any_of(link.visual, is_mesh) ||
           std::ranges::any_of(link.collision, is_mesh);
  });
}

/// Reads one URDF, hashes its files, and adds its meshes or replaces them by primitives.
class DescriptionReader {
 public:
  DescriptionReader(const MujocoPlantOptions& options, ModelSources& sources, ContentHash& hash)
      : options_(options), sources_(sources), hash_(hash) {}

  RobotDescription Read(const std::filesystem::path& urdf) {
    const std::string text = ReadFileBytes(urdf, "the robot's URDF");
    hash_.Add(text);
    RobotDescription robot = ParseUrdf(text, urdf.string());
    if (sources_.uses_meshes) {
      for (const Link& link : robot.links) {
        for (const Shape& shape : link.visual) ReadMesh(shape, link, urdf);
        for (const Shape& shape : link.collision) ReadMesh(shape, link, urdf);
      }
    } else if (NamesMeshes(robot)) {
      auto file = urdf.parent_path() / "primitives.yaml";
      if (!std::filesystem::exists(file)) {  // an arm that looks like the Panda
        file = urdf.parent_path().parent_path() / "panda" / "primitives.yaml";
      }
      const std::string shapes = ReadFileBytes(
          file, "the primitive shapes, which stand in for the meshes where the package is missing");
      hash_.Add(shapes);
      UsePrimitives(shapes, file.string(), robot);
    }
    return robot;
  }

 private:
  void ReadMesh(const Shape& shape, const Link& link, const std::filesystem::path& urdf) {
    if (shape.kind != ShapeKind::kMesh || sources_.meshes.contains(shape.mesh_uri)) return;
    MeshFile mesh;
    try {
      mesh.file = ResolveMesh(shape.mesh_uri, options_, urdf.parent_path());
      mesh.bytes = ReadFileBytes(mesh.file, fmt::format("mesh '{}'", shape.mesh_uri));
    } catch (const InputError& error) {
      throw InputError(fmt::format(
          "{}: link '{}': {}. Run scripts/setup to fetch the meshes again, or name no mesh package "
          "to run on primitive shapes",
          urdf.string(), link.name, error.what()));
    }
    hash_.Add(shape.mesh_uri);
    hash_.Add(mesh.bytes);
    sources_.meshes.emplace(shape.mesh_uri, std::move(mesh));
  }

  const MujocoPlantOptions& options_;
  ModelSources& sources_;
  ContentHash& hash_;
};

/// Requires one chain of seven revolute joints; all other links are fixed to it.
void RequireSevenJoints(const RobotDescription& robot, const std::filesystem::path& urdf) {
  std::map<std::string, std::size_t> depths;
  std::size_t joints = 0;
  bool chain = true;
  for (const Link& link : robot.links) {
    const std::size_t depth = link.parent.empty() ? 0 : depths.at(link.parent);
    const bool moves = link.joint_kind == JointKind::kRevolute;
    chain = chain && (!moves || depth == joints);
    joints += moves ? 1 : 0;
    depths[link.name] = depth + (moves ? 1 : 0);
  }
  if (chain && joints == kJoints) return;
  throw InputError(
      fmt::format("{}: robot '{}' has {} revolute joints{}; the arm must be one chain of {}",
                  urdf.string(), robot.name, joints, chain ? "" : " on several branches", kJoints));
}

std::vector<Link> Fingers(const RobotDescription& robot) {
  std::vector<Link> fingers;
  std::ranges::copy_if(robot.links, std::back_inserter(fingers),
                       [](const Link& link) { return link.joint_kind == JointKind::kPrismatic; });
  return fingers;
}

void RequireNoWheels(const RobotDescription& robot, const std::filesystem::path& urdf) {
  for (const Link& link : robot.links) {
    if (link.joint_kind != JointKind::kContinuous) continue;
    throw InputError(
        fmt::format("{}: joint '{}' of robot '{}' is continuous; only a mobile base "
                    "has such joints, its wheels",
                    urdf.string(), link.joint, robot.name));
  }
}

void RequireNoFingers(const RobotDescription& robot, const std::filesystem::path& urdf) {
  const auto found = Fingers(robot);
  if (found.empty()) return;
  throw InputError(
      fmt::format("{}: joint '{}' of robot '{}' is prismatic; only the Franka Hand has such",
                  urdf.string(), found.front().joint, robot.name));
}

/// Requires the joints of two fingers, of which the second follows the first.
void RequireTwoFingers(const RobotDescription& robot, const std::filesystem::path& urdf) {
  const auto found = Fingers(robot);
  if (found.size() == 2 && found[0].follows.empty() && found[1].follows == found[0].joint) return;
  throw InputError(fmt::format(
      "{}: the hand has {} prismatic joints; it must have two, the second with a <mimic> of the "
      "first",
      urdf.string(), found.size()));
}

/// Requires a vacuum gripper without joints of its own.
void RequireCups(const RobotDescription& robot, const std::filesystem::path& urdf) {
  RequireNoFingers(robot, urdf);
  const auto cups =
      static_cast<std::size_t>(std::ranges::count_if(robot.links, [](const Link& link) {
        return std::ranges::any_of(link.collision, &Shape::lip);
      }));
  if (cups >= 1 && cups <= kMostCups) return;
  throw InputError(fmt::format(
      "{}: {} links have collision shapes named lip...; a vacuum gripper has one to {} suction cups",
      urdf.string(), cups, kMostCups));
}

/// 2/5 m r^2 about its centre, kg m^2.
double InertiaOfSteelBall(double mass) {
  constexpr double kDensity = 7850;  // kg / m^3
  return 0.4 * mass * std::pow(0.75 * mass / (std::numbers::pi * kDensity), 2.0 / 3.0);
}

void RequireVisualError(double error) {
  if (error >= 0 && error <= 0.01) return;
  throw InputError(fmt::format(
      "visual_error is {} m; it must be in [0, 0.01], 0 for the meshes as they are", error));
}

/// A mobile base's tilt follows from its tyres.
void RequireLevel(const MujocoPlantOptions& options) {
  if (options.base_tilt == BaseTilt()) return;
  throw InputError(
      "base_tilt: the arm stands on a mobile base, which finds its own attitude; leave one out");
}

/// Scales the robot's masses relative to its URDF.
void ScaleMasses(double scale, RobotDescription& robot) {
  for (Link& link : robot.links) {
    if (!link.inertial) continue;
    link.inertial->mass *= scale;
    for (double& moment : link.inertial->I) moment *= scale;
  }
}

/// Gives the links behind the seven joints other mass properties. @param links  seven or none.
void ReplaceInertials(const std::vector<setting::Load>& links, RobotDescription& robot) {
  auto link = links.begin();
  for (Link& one : robot.links) {
    if (one.joint_kind != JointKind::kRevolute || link == links.end()) continue;
    one.inertial = Inertial{link->m_load, link->F_x_Cload, link->I_load};
    ++link;
  }
}

/// Fixes the load to the flange: the last link of the arm.
void Attach(const setting::Load& load, RobotDescription& robot) {
  if (const auto bad = FindBadValue(load)) {
    throw InputError(fmt::format("{}: {}", kLoadText, Describe(*bad)));
  }
  if (load.m_load == 0) return;
  Link body;
  body.name = kLoadBody;
  body.parent = robot.links.back().name;
  body.inertial = Inertial{load.m_load, load.F_x_Cload, load.I_load};
  if (load.I_load == Matrix3{}) {
    const double I = InertiaOfSteelBall(load.m_load);
    body.inertial->I = {I, 0, 0, 0, I, 0, 0, 0, I};
  }
  RequireThickness(kLoadText, body.inertial->I);
  robot.links.push_back(body);
}

/// Puts the arm where it stands in the world.
void Stand(const ArmPose& pose, RobotDescription& robot) {
  if (pose == ArmPose()) return;
  Pose& X_WO = robot.links.front().X_PL;
  X_WO.p = pose.position;
  X_WO.quat = {std::cos(pose.yaw / 2), 0, 0, std::sin(pose.yaw / 2)};
}

/// Names one arm's links and joints apart from those of the others.
void Rename(const std::string& prefix, RobotDescription& robot) {
  for (Link& link : robot.links) {
    for (std::string* name : {&link.name, &link.parent, &link.joint, &link.follows}) {
      if (!name->empty()) name->insert(0, prefix);
    }
  }
}

void HashArm(const MujocoPlantOptions& options, const ArmSources& arm, ContentHash& hash) {
  hash.Add(fmt::format("load {} {} {}", options.load.m_load, fmt::join(options.load.F_x_Cload, " "),
                       fmt::join(options.load.I_load, " ")));
  if (options.arm.armature) {
    hash.Add(fmt::format("rotors {}", fmt::join(arm.armature, " ")));
  }
  for (const setting::Load& link : options.arm.links) {
    hash.Add(fmt::format("link {} {} {}", link.m_load, fmt::join(link.F_x_Cload, " "),
                         fmt::join(link.I_load, " ")));
  }
  if (options.mass_scale != 1) hash.Add(fmt::format("mass scale {}", options.mass_scale));
  if (!(options.pose == ArmPose())) {
    hash.Add(fmt::format("pose {} {}", fmt::join(options.pose.position, " "), options.pose.yaw));
  }
  if (!options.prefix.empty()) hash.Add(fmt::format("prefix {}", options.prefix));
}

ArmSources ReadArm(const MujocoPlantOptions& options, const ModelSources& sources,
                   DescriptionReader& reader, ContentHash& hash) {
  Validate(options.arm, options.armature);
  ArmSources arm;
  arm.armature = RotorInertia(options.armature, options.arm);
  arm.friction = options.arm.friction_law ? FrictionProfile::kNone : options.friction;
  hash.Add(fmt::format("mujoco {} friction {} armature {} hand {} meshes {}", mj_version(),
                       static_cast<int>(arm.friction), options.armature,
                       static_cast<int>(options.hand), sources.uses_meshes));
  HashArm(options, arm, hash);
  hash.Add(fmt::format("visual error {}", options.visual_error));
  RobotDescription& robot = arm.robot;
  robot = reader.Read(options.urdf);
  ReplaceInertials(options.arm.links, robot);
  if (options.mass_scale != 1) ScaleMasses(options.mass_scale, robot);
  RequireNoWheels(robot, options.urdf);
  RequireSevenJoints(robot, options.urdf);
  RequireNoFingers(robot, options.urdf);
  Attach(options.load, robot);
  if (options.hand != HandKind::kNone) {
    const bool has_fingers = options.hand == HandKind::kFrankaHand;
    const std::string name = has_fingers ? "hand" : "cobot_pump";
    const auto urdf = options.urdf.parent_path() / ".." / name / (name + ".urdf");
    RobotDescription hand = reader.Read(urdf);
    if (options.mass_scale != 1) ScaleMasses(options.mass_scale, hand);
    Mount(robot, hand, urdf.string());
    RequireNoWheels(robot, urdf);
    RequireSevenJoints(robot, urdf);
    has_fingers ? RequireTwoFingers(robot, urdf) : RequireCups(robot, urdf);
  }
  Stand(options.pose, robot);
  if (!options.prefix.empty()) Rename(options.prefix, robot);
  if (options.base) {
    RequireLevel(options);
    PutOnBase(ReadBase(options.base->urdf, hash), kArmMount, robot, options.base->urdf.string());
  }
  return arm;
}

}  // namespace

ModelSources ReadModelSources(std::span<const MujocoPlantOptions> arms) {
  const MujocoPlantOptions& common = arms.front();
  ModelSources sources;
  RequireVisualError(common.visual_error);
  sources.visual_error = common.visual_error;
  sources.uses_meshes =
      !common.mesh_package.empty() && std::filesystem::is_directory(common.mesh_package);
  ContentHash hash;
  hash.Add(kComposition);
  DescriptionReader reader(common, sources, hash);
  for (const MujocoPlantOptions& options : arms) {
    sources.arms.push_back(ReadArm(options, sources, reader, hash));
  }
  sources.scene_file = common.scene;
  sources.scene_text =
      common.scene.empty() ? std::string(kPlainScene) : ReadFileBytes(common.scene, "the scene");
  sources.scene_is_self_contained = FilesNamedIn(sources.scene_text).files.empty();
  hash.Add(sources.scene_text);
  Validate(common.objects);
  sources.objects_text = ObjectsMjcf(common.objects);
  if (!common.objects.empty()) hash.Add(ObjectsKey(common.objects));
  sources.key = hash.Hex();
  return sources;
}

}  // namespace twin::plant
