#include "plant/mjcf_writer.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "plant/base_joints.h"
#include "plant/hand_joints.h"
#include "plant/joint_parameters.h"

namespace twin::plant {
namespace {

// Sizes, for each arm: room for the joints' own constraints and 100 contacts of 4 rows; a box in
// the hand makes 16, one on a table 4. Classes copy their settings before the scene's defaults are
// read, so those do not affect the robot.
//
// Grasped objects must not creep. Friction of soft contacts creeps unless the cone is elliptic and
// the solver's last iterations remove the slip, and it holds a rotating object only where contacts
// resist torsion (condim 4). A pad's settings apply to all its contacts: rubber on a hard object,
// torsion by a patch of 5 mm radius; stiff, because the opening decides on a grasp.
//
// One creep remains. The friction rows request J(q_k) dq_k+1 = (1 - B T) J(q_k) dq_k; the hand
// moves on arcs, which adds T c per step, c the acceleration of that curvature. So the object lags
// behind at a speed of c (1/B - T/2): zero at B T = 2, where the rows would also oscillate for
// ever. The pads' B = 1500 1/s leaves a sixth of a micrometre per second for each mm/s^2 of c;
// MuJoCo's own parameter for B allows at most 1/T, which leaves three times as much.
//
// A suction cup's lip is a ring of spheres, which resists torsion as a whole. Its friction is that
// of a cup on dry glass, stone or smooth plastic (0.5, Schmalz' notes on the design of vacuum
// systems). Within the gap the engine tells of a contact without force: the give of a lip, by which
// it seals (suction.cc).
//
// A tyre's contact only carries load: its friction law is in tyre.h. Under a mobile base the
// contact yields by about a millimetre, critically damped.
constexpr std::string_view kPreamble = R"(<mujoco model="{}">
  <size njmax="{}" nconmax="{}"/>
  <option cone="elliptic" impratio="10" noslip_iterations="5"/>
  <visual>
    <global offwidth="1280" offheight="960"/>
    <quality shadowsize="2048" offsamples="4"/>
  </visual>
  <default>
    <default class="twin_visual">
      <mesh scale="1 1 1"/>
      <geom contype="0" conaffinity="0" group="2" mass="0"/>
    </default>
    <default class="twin_collision">
      <mesh scale="1 1 1"/>
      <geom group="3" mass="0" rgba="0.6 0.6 0.9 0.5"/>
      <joint limited="true" range="-1 1"
             solreffriction="0.004 1" solimpfriction="0.999 0.999 0.001 0.5 2"/>
    </default>
    <default class="twin_pad">
      <geom group="3" mass="0" rgba="0.3 0.3 0.3 0.5" priority="1" condim="4"
            friction="1 0.005 0.0001" solref="-62500 -1500" solimp="0.98 0.999 0.001"/>
    </default>
    <default class="twin_lip">
      <geom group="3" mass="0" rgba="0.3 0.3 0.3 0.5" priority="1" condim="3"
            friction="0.5 0.005 0.0001" solref="-62500 -1500" solimp="0.98 0.999 0.001"
            margin="0.002" gap="0.002"/>
    </default>
    <default class="twin_tyre">
      <geom group="3" mass="0" rgba="0.3 0.3 0.3 0.5" priority="1" condim="1" solref="0.01 1"/>
    </default>
    <default class="twin_object"/>
    <default class="twin_finger">
      <joint limited="true" range="-1 1" solreflimit="0.004 1" solimplimit="0.98 0.999 0.001"/>
    </default>
  </default>
)";

constexpr std::string_view kClosing = R"(  <include file="{}"/>
  <option timestep="0.001" integrator="Euler" solver="Newton"/>
</mujoco>
)";

std::string Row(std::span<const double> values, char separator = ' ') {
  std::string row;
  for (const double value : values) {
    if (!row.empty()) row += separator;
    row += fmt::format("{}", value);
  }
  return row;
}

std::string PoseAttributes(const Pose& pose) {
  return fmt::format(R"(pos="{}" quat="{}")", Row(pose.p), Row(pose.quat));
}

/// Writes one document; members are state shared by its parts.
class Writer {
 public:
  Writer(const ModelSources& sources, const MeshAssets& visual, const MeshAssets& collision)
      : sources_(sources), visual_(visual), collision_(collision) {}

  std::string Write() {
    const std::size_t arms = sources_.arms.size();
    const std::size_t rows = 420 * arms;
    const std::size_t contacts = 100 * arms;
    Line(kPreamble, sources_.arms.front().robot.name, rows, contacts);
    std::string bodies;
    std::swap(bodies, text_);
    Line("  <worldbody>\n");
    for (const ArmSources& arm : sources_.arms) {
      arm_ = &arm;
      joint_ = 0;
      Body(arm.robot.links.front());
    }
    text_ += sources_.objects_text;
    Line("  </worldbody>\n");
    std::swap(bodies, text_);  // assets are known after the bodies
    Assets();
    text_ += bodies;
    Excludes();
    Line(kClosing, kSceneFile);
    return std::move(text_);
  }

 private:
  template <typename... Args>
  void Line(std::string_view format, const Args&... args) {
    text_ += fmt::vformat(format, fmt::make_format_args(args...));
  }

  std::string Material(const Colour& colour) {
    auto found = std::find(colours_.begin(), colours_.end(), colour);
    if (found == colours_.end()) found = colours_.insert(colours_.end(), colour);
    return fmt::format("twin_colour_{}", found - colours_.begin());
  }

  void Assets() {
    Line("  <asset>\n");
    for (std::size_t i = 0; i < colours_.size(); ++i) {
      Line(
          "    <material name=\"twin_colour_{}\" rgba=\"{}\" specular=\"0.35\" "
          "shininess=\"0.4\"/>\n",
          i, Row(colours_[i]));
    }
    for (const auto& [name, line] : meshes_) text_ += line;
    Line("  </asset>\n");
  }

  /// @returns name of the mesh asset; the same file at the same scale is one asset.
  std::string Mesh(const MeshAsset& asset, const Vector3& scale, std::string_view use) {
    std::string name = fmt::format("{}_{}", asset.file, Row(scale, '_'));
    meshes_[name] =
        fmt::format("    <mesh name=\"{}\" class=\"twin_{}\" file=\"{}\" scale=\"{}\"/>\n", name,
                    use, asset.file, Row(scale));
    return name;
  }

  void Geom(const Shape& shape, std::string_view use, const std::string& name) {
    if (shape.kind == ShapeKind::kMesh) {
      const MeshAssets& assets = use == "visual" ? visual_ : collision_;
      int part = 0;
      for (const MeshAsset& asset : assets.at(shape.mesh_uri)) {
        Line("<geom name=\"{}_{}\" class=\"twin_{}\" type=\"mesh\" mesh=\"{}\" {}{}/>\n", name,
             part++, use, Mesh(asset, shape.size, use), PoseAttributes(shape.X_LS),
             Look(shape.colour.value_or(asset.colour), use));
      }
      return;
    }
    static constexpr std::array<std::string_view, 5> kTypes{"mesh", "box", "cylinder", "capsule",
                                                            "sphere"};
    Line("<geom name=\"{}\" class=\"twin_{}\" type=\"{}\" size=\"{}\" {}{}/>\n", name, use,
         kTypes[static_cast<std::size_t>(shape.kind)], Row(shape.size), PoseAttributes(shape.X_LS),
         Look(shape.colour.value_or(Colour{0.8, 0.8, 0.8, 1}), use));
  }

  std::string Look(const Colour& colour, std::string_view use) {
    if (use != "visual") return {};
    return fmt::format(" material=\"{}\"", Material(colour));
  }

  void Body(const Link& link) {
    Line("<body name=\"{}\" {}>\n", link.name, PoseAttributes(link.X_PL));
    // A link without mass needs an explicit zero, or the engine derives a mass from its shapes.
    const Inertial inertial = link.inertial.value_or(Inertial{});
    const Matrix3& I = inertial.I;
    if (inertial.mass > 0) {
      Line("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>\n", Row(inertial.com),
           inertial.mass, Row(std::array{I[0], I[4], I[8], I[3], I[6], I[7]}));
    } else {
      Line("<inertial pos=\"0 0 0\" mass=\"0\" diaginertia=\"0 0 0\"/>\n");
    }
    if (link.joint_kind == JointKind::kRevolute) Joint(link);
    if (link.joint_kind == JointKind::kPrismatic) Finger(link);
    if (link.joint_kind == JointKind::kContinuous) Wheel(link);
    if (link.joint_kind == JointKind::kFree) Line("<freejoint name=\"{}\"/>\n", link.joint);
    int number = 0;
    for (const Shape& shape : link.visual) {
      Geom(shape, "visual", fmt::format("{}_visual_{}", link.name, number++));
    }
    number = 0;
    for (const Shape& shape : link.collision) {
      Geom(shape, CollisionClass(link, shape), fmt::format("{}_collision_{}", link.name, number++));
    }
    for (const Link& child : arm_->robot.links) {
      if (child.parent == link.name) Body(child);
    }
    Line("</body>\n");
  }

  void Joint(const Link& link) {
    const bool breakaway = arm_->friction == FrictionProfile::kBreakaway;
    Line(
        "<joint name=\"{}\" class=\"twin_collision\" type=\"hinge\" axis=\"{}\" armature=\"{}\" "
        "frictionloss=\"{}\" damping=\"{}\"/>\n",
        link.joint, Row(link.axis), arm_->armature[joint_],
        breakaway ? kBreakawayTorque[joint_] : 0.0, breakaway ? kViscousFriction[joint_] : 0.0);
    ++joint_;
  }

  void Finger(const Link& link) {
    Line(
        "<joint name=\"{}\" class=\"twin_finger\" type=\"slide\" axis=\"{}\" "
        "armature=\"{}\"/>\n",
        link.joint, Row(link.axis), kFingerInertia);
  }

  void Wheel(const Link& link) {
    Line("<joint name=\"{}\" type=\"hinge\" axis=\"{}\" armature=\"{}\"/>\n", link.joint,
         Row(link.axis), kWheelRotorInertia);
  }

  static std::string_view CollisionClass(const Link& link, const Shape& shape) {
    if (link.joint_kind == JointKind::kContinuous) return "tyre";
    if (shape.lip) return "lip";
    return shape.pad ? "pad" : "collision";
  }

  /// Number of arm joints between the root and each link.
  static std::map<std::string, int> JointDepths(const RobotDescription& robot) {
    std::map<std::string, int> depths;
    for (const Link& link : robot.links) {
      const int own = link.joint_kind == JointKind::kRevolute ? 1 : 0;
      depths[link.name] = (link.parent.empty() ? 0 : depths.at(link.parent)) + own;
    }
    return depths;
  }

  /// Excludes collisions between links of one arm up to two joints apart: the hulls of their shapes
  /// overlap within the joint limits, the links do not. (MoveIt's SRDF of the Panda excludes the
  /// same pairs.) Fingers meet at the end of their range, not as shapes.
  void Excludes() {
    Line("  <contact>\n");
    for (const ArmSources& arm : sources_.arms) ExcludesOf(arm.robot);
    Line("  </contact>\n");
  }

  void ExcludesOf(const RobotDescription& robot) {
    const auto depths = JointDepths(robot);
    for (const Link& a : robot.links) {
      for (const Link& b : robot.links) {
        const int apart = depths.at(b.name) - depths.at(a.name);
        const bool fingers = a.joint_kind == JointKind::kPrismatic &&
                             b.joint_kind == JointKind::kPrismatic && a.name < b.name;
        if ((apart < 1 || apart > 2) && !fingers) continue;
        if (a.collision.empty() || b.collision.empty()) continue;
        Line("    <exclude body1=\"{}\" body2=\"{}\"/>\n", a.name, b.name);
      }
    }
  }

  const ModelSources& sources_;
  const MeshAssets& visual_;
  const MeshAssets& collision_;
  std::string text_;
  std::vector<Colour> colours_;
  std::map<std::string, std::string> meshes_;
  const ArmSources* arm_ = nullptr;  ///< being written
  std::size_t joint_ = 0;            ///< of it
};

}  // namespace

std::string WriteMjcf(const ModelSources& sources, const MeshAssets& visual,
                      const MeshAssets& collision) {
  return Writer(sources, visual, collision).Write();
}

}  // namespace twin::plant
