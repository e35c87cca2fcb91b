#include "plant/robot_description.h"

#include <algorithm>
#include <cmath>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/link.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>
#include <Eigen/Geometry>

#include "twin/core/error.h"

namespace twin::plant {
namespace {

/// Captures urdfdom's terminal output for our error text.
class CapturedMessages final : public console_bridge::OutputHandler {
 public:
  CapturedMessages() { console_bridge::useOutputHandler(this); }
  ~CapturedMessages() override { console_bridge::restorePreviousOutputHandler(); }
  CapturedMessages(const CapturedMessages&) = delete;
  CapturedMessages& operator=(const CapturedMessages&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (!text_.empty()) text_ += "; ";
    text_ += text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

Vector3 ToVector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

Pose ToPose(const urdf::Pose& pose) {
  return {ToVector(pose.position),
          {pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z}};
}

Shape ToShape(const urdf::Geometry& geometry, const urdf::Pose& origin) {
  Shape shape;
  shape.X_LS = ToPose(origin);
  switch (geometry.type) {
    case urdf::Geometry::SPHERE:
      shape.kind = ShapeKind::kSphere;
      shape.size = {static_cast<const urdf::Sphere&>(geometry).radius, 0, 0};
      break;
    case urdf::Geometry::BOX: {
      const auto& dim = static_cast<const urdf::Box&>(geometry).dim;
      shape.kind = ShapeKind::kBox;
      shape.size = {dim.x / 2, dim.y / 2, dim.z / 2};
      break;
    }
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
      shape.kind = ShapeKind::kCylinder;
      shape.size = {cylinder.radius, cylinder.length / 2, 0};
      break;
    }
    case urdf::Geometry::MESH: {
      const auto& mesh = static_cast<const urdf::Mesh&>(geometry);
      shape.size = ToVector(mesh.scale);
      shape.mesh_uri = mesh.filename;
      break;
    }
  }
  return shape;
}

/// Converts the inertia from the axes of URDF's inertial frame to the link's.
Inertial ToInertial(const urdf::Inertial& source) {
  Eigen::Matrix3d I;
  I << source.ixx, source.ixy, source.ixz, source.ixy, source.iyy, source.iyz, source.ixz,
      source.iyz, source.izz;
  const auto& rotation = source.origin.rotation;
  const Eigen::Matrix3d R =
      Eigen::Quaterniond(rotation.w, rotation.x, rotation.y, rotation.z).toRotationMatrix();
  Inertial inertial{source.mass, ToVector(source.origin.position), {}};
  Eigen::Map<Eigen::Matrix3d>(inertial.I.data()) = R * I * R.transpose();
  return inertial;
}

JointKind KindOf(const urdf::Joint& joint, const std::string& where) {
  switch (joint.type) {
    case urdf::Joint::FIXED: return JointKind::kFixed;
    case urdf::Joint::REVOLUTE: return JointKind::kRevolute;
    case urdf::Joint::PRISMATIC: return JointKind::kPrismatic;
    case urdf::Joint::CONTINUOUS: return JointKind::kContinuous;
    default: break;
  }
  throw InputError(fmt::format(
      "{}: joint '{}' is neither revolute, continuous, prismatic nor fixed; only these are "
      "supported",
      where, joint.name));
}

/// @returns name of the joint that `joint` follows; empty when none.
std::string FollowedBy(const urdf::Joint& joint, const std::string& where) {
  if (!joint.mimic) return {};
  if (joint.mimic->multiplier == 1 && joint.mimic->offset == 0) return joint.mimic->joint_name;
  throw InputError(fmt::format(
      "{}: joint '{}' mimics '{}' with multiplier {} and offset {}; only 1 and 0 are supported",
      where, joint.name, joint.mimic->joint_name, joint.mimic->multiplier, joint.mimic->offset));
}

void FillJoint(const urdf::Joint& joint, const std::string& where, Link& link) {
  link.joint = joint.name;
  link.parent = joint.parent_link_name;
  link.X_PL = ToPose(joint.parent_to_joint_origin_transform);
  link.joint_kind = KindOf(joint, where);
  if (link.joint_kind == JointKind::kFixed) return;
  link.follows = FollowedBy(joint, where);
  link.axis = ToVector(joint.axis);
  if (!HasRange(link.joint_kind)) return;
  link.q_min = joint.limits->lower;  // urdfdom rejects such a joint without limits
  link.q_max = joint.limits->upper;
  if (!std::isfinite(link.q_min) || !std::isfinite(link.q_max) || link.q_min >= link.q_max) {
    throw InputError(
        fmt::format("{}: joint '{}' has the range [{}, {}] {}; lower must be below "
                    "upper",
                    where, joint.name, link.q_min, link.q_max,
                    link.joint_kind == JointKind::kRevolute ? "rad" : "m"));
  }
  link.tau_max = joint.limits->effort;
  if (!std::isfinite(link.tau_max) || link.tau_max <= 0) {
    throw InputError(fmt::format("{}: joint '{}' has the effort {} {}; it must be above 0", where,
                                 joint.name, link.tau_max,
                                 link.joint_kind == JointKind::kRevolute ? "Nm" : "N"));
  }
}

Link ToLink(const urdf::Link& source, const std::string& where) {
  Link link;
  link.name = source.name;
  if (source.parent_joint) FillJoint(*source.parent_joint, where, link);
  if (source.inertial) link.inertial = ToInertial(*source.inertial);
  for (const auto& visual : source.visual_array) {
    link.visual.push_back(ToShape(*visual->geometry, visual->origin));
    if (!visual->material) continue;
    const auto& c = visual->material->color;
    link.visual.back().colour = Colour{c.r, c.g, c.b, c.a};
  }
  for (const auto& collision : source.collision_array) {
    link.collision.push_back(ToShape(*collision->geometry, collision->origin));
    link.collision.back().pad = collision->name.starts_with("pad");
    link.collision.back().lip = collision->name.starts_with("lip");
  }
  return link;
}

void Append(const urdf::Link& source, const std::string& where, RobotDescription& robot) {
  robot.links.push_back(ToLink(source, where));
  for (const auto& child : source.child_links) Append(*child, where, robot);
}

}  // namespace

const Link* RobotDescription::Find(const std::string& link) const noexcept {
  const auto found = std::find_if(links.begin(), links.end(), [&link](const Link& candidate) {
    return candidate.name == link;
  });
  return found == links.end() ? nullptr : &*found;
}

RobotDescription ParseUrdf(const std::string& text, const std::string& where) {
  const CapturedMessages messages;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: not a valid URDF: {}", where, error.what()));
  }
  if (!model || !model->getRoot() || !messages.text().empty()) {
    throw InputError(fmt::format("{}: not a valid URDF: {}", where,
                                 messages.text().empty() ? "no root link" : messages.text()));
  }
  RobotDescription robot;
  robot.name = model->getName();
  Append(*model->getRoot(), where, robot);
  return robot;
}

void PutOnBase(const RobotDescription& base, const std::string& mount, RobotDescription& robot,
               const std::string& where) {
  if (base.Find(mount) == nullptr) {
    throw InputError(fmt::format("{}: base '{}' has no link '{}', where the arm would stand", where,
                                 base.name, mount));
  }
  for (const Link& link : robot.links) {
    if (base.Find(link.name) == nullptr) continue;
    throw InputError(fmt::format("{}: link '{}' is also a link of robot '{}'; names must differ",
                                 where, link.name, robot.name));
  }
  Link& root = robot.links.front();
  root.parent = mount;
  root.joint = mount + "_joint";
  robot.links.insert(robot.links.begin(), base.links.begin(), base.links.end());
}

void Mount(RobotDescription& robot, const RobotDescription& tool, const std::string& where) {
  const std::string& mount = tool.links.front().name;
  if (robot.Find(mount) == nullptr) {
    throw InputError(fmt::format(
        "{}: its root link '{}' must be a link of robot '{}', which has none of that name", where,
        mount, robot.name));
  }
  for (auto link = tool.links.begin() + 1; link != tool.links.end(); ++link) {
    if (robot.Find(link->name) != nullptr) {
      throw InputError(fmt::format("{}: link '{}' is also a link of robot '{}'; names must differ",
                                   where, link->name, robot.name));
    }
    robot.links.push_back(*link);
  }
}

}  // namespace twin::plant
