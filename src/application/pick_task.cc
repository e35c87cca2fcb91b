#include "application/pick.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/core/random.h"
#include "twin/model/transform.h"
#include "twin/scenario/objects.h"

namespace twin::application {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kFarthestGrasp = 2;  // m: beyond any reach

/// Name of the ground plane in the scenes.
constexpr const char* kFloor = "floor";

scenario::FramePose ReadPlace(control::ParameterReader& p, const std::string& key, double least) {
  return {.position = p.Vector(key + "position", Dimension::kLength, {}, least * kFarthestGrasp,
                               kFarthestGrasp),
          .rpy = p.Vector(key + "rpy", Dimension::kAngle, {}, least * kFullTurn, kFullTurn)};
}

void ReadPace(control::ParameterReader& p, const std::string& key, reference::Timing& pace) {
  pace.velocity_scale = p.Number(key + "velocity_scale", pace.velocity_scale, 0.01, 1);
  pace.acceleration_scale = p.Number(key + "acceleration_scale", pace.acceleration_scale, 0.001, 1);
  pace.jerk_scale = p.Number(key + "jerk_scale", pace.jerk_scale, 0.001, 1);
}

PickOptions ReadOptions(control::ParameterReader& p) {
  PickOptions o;
  o.above = p.Quantity("above", Dimension::kLength, o.above, 0.02, 0.3);
  o.clearance = p.Quantity("clearance", Dimension::kLength, o.clearance, 0.003, 0.05);
  o.budget = static_cast<std::uint64_t>(p.Number("budget", static_cast<double>(o.budget), 0, 1e7));
  o.gap = p.Quantity("gap", Dimension::kLength, o.gap, 0, 0.005);
  ReadPace(p, "pace.", o.pace);
  ReadPace(p, "down_pace.", o.down_pace);
  o.follow.K_P = p.Quantity("controller.K_P", Dimension::kRate, o.follow.K_P, 0.1, 100);
  o.follow.alpha = p.Number("controller.alpha", o.follow.alpha, 0, 1);
  return o;
}

std::string RequiredText(control::ParameterReader& p, const char* key) {
  std::string text = p.Text(key, "");
  if (text.empty()) p.Refuse(key, "is missing; name one of the scenario's objects");
  return text;
}

template <typename Object>
const Object& FindObject(const std::vector<Object>& objects, const std::string& name,
                         const std::string& key) {
  const auto found = std::ranges::find(objects, name, &Object::name);
  if (found != objects.end()) return *found;
  std::string names;
  for (const Object& object : objects) names += (names.empty() ? "" : ", ") + object.name;
  throw InputError(
      fmt::format("{}\"{}\" is none of the scenario's objects; {}", key, name,
                  names.empty() ? "it has none: list them under objects" : "it has: " + names));
}

/// A random pose about another one, from the scenario's seed.
/// @param draw  number of the draw: one per pose.
scenario::FramePose Drawn(const scenario::FramePose& pose, const scenario::FramePose& spread,
                          std::uint64_t seed, std::uint64_t draw) {
  const Random random(seed, RandomStream::kPlace);
  scenario::FramePose drawn = pose;
  for (std::uint32_t i = 0; i < 3; ++i) {
    drawn.position[i] += spread.position[i] * (2 * random.Uniform(draw, i) - 1);
    drawn.rpy[i] += spread.rpy[i] * (2 * random.Uniform(draw, 3 + i) - 1);
  }
  return drawn;
}

Vector3 NormalOf(const Transform& top) {
  return {top[8], top[9], top[10]};
}

// Dimensions of the Franka Hand from the midpoint of its fingertips: models/robots/hand/hand.urdf.
constexpr double kPalm = 0.0374;      // m, up to the palm
constexpr double kTip = 0.0088;       // m, down to the tips
constexpr double kLeastHold = 0.004;  // m, least height of the object above this midpoint

/// A cylinder stands if the cosine of its axis's angle from the vertical is larger.
constexpr double kStands = 0.7;

/// An axis along which the fingers close, and the object's width between them.
struct Closing {
  Vector3d axis;
  double width = 0;
};

/// The object's axis that points up; of a lying cylinder the upward direction across its axis.
Vector3d UpOf(const plant::SceneObject& object, const Vector3d& up) {
  Vector3d nearest = Vector3d::Zero();
  if (object.shape == plant::ObjectShape::kCylinder && std::abs(up.z()) < kStands) {
    return Vector3d(up.x(), up.y(), 0).normalized();
  }
  Eigen::Index axis = 2;
  if (object.shape == plant::ObjectShape::kBox) up.cwiseAbs().maxCoeff(&axis);
  nearest[axis] = up[axis] < 0 ? -1 : 1;
  return nearest;
}

std::vector<Closing> ClosingsOf(const plant::SceneObject& object, const Vector3d& up) {
  std::vector<Closing> closings;
  if (object.shape == plant::ObjectShape::kBox) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (std::abs(up[axis]) > 0.5) continue;
      closings.push_back({Vector3d::Unit(axis), object.size[static_cast<std::size_t>(axis)]});
    }
  } else if (std::abs(up.z()) > 0.5) {
    for (int eighth = 0; eighth < 4; ++eighth) {
      const double angle = eighth * std::numbers::pi / 4;
      closings.push_back({Vector3d(std::cos(angle), std::sin(angle), 0), object.size[0]});
    }
  } else {
    closings.push_back({up.cross(Vector3d::UnitZ()), object.size[0]});
    closings.push_back({Vector3d::UnitZ(), object.size[2]});
  }
  return closings;
}

/// Half of the object's extent along `up`, object's axes.
double HalfAlong(const plant::SceneObject& object, const Vector3d& up) {
  if (object.shape != plant::ObjectShape::kBox) {
    return (std::abs(up.z()) > 0.5 ? object.size[2] : object.size[0]) / 2;
  }
  return up.cwiseAbs().dot(Vector3d(object.size.data())) / 2;
}

}  // namespace

PickParameters::PickParameters(control::ParameterReader& p)
    : object(RequiredText(p, "object")),
      on(RequiredText(p, "place.on")),
      place(ReadPlace(p, "place.", -1)),
      spread(ReadPlace(p, "place.spread.", 0)),
      perception(ReadPlace(p, "perception.spread.", 0)),
      force(p.Quantity("grasp.force", Dimension::kForce, 40, 1, 140)),
      speed(p.Quantity("grasp.speed", Dimension::kVelocity, 0.05, 0.001, 0.1)),
      tolerance(p.Quantity("grasp.tolerance", Dimension::kLength, 0.003, 1e-4, 0.04)),
      tries(static_cast<int>(p.Number("grasp.tries", 3, 1, 10))),
      options(ReadOptions(p)),
      object_key(p.PlaceOf("object")),
      on_key(p.PlaceOf("place.on")) {}

PickTask TaskOf(const scenario::Scenario& scenario, const PickParameters& parameters) {
  const std::vector<plant::SceneObject> objects = ObjectsOf(scenario.objects, scenario.seed);
  const plant::SceneObject& object = FindObject(objects, parameters.object, parameters.object_key);
  if (!object.mass || object.shape == plant::ObjectShape::kSphere) {
    throw InputError(fmt::format("{}{} is {}", parameters.object_key, object.name,
                                 object.mass ? "a sphere, which does not stay where it is put"
                                             : "fixed to the world; give it a mass"));
  }
  const plant::SceneObject& below = FindObject(objects, parameters.on, parameters.on_key);
  const scenario::ObjectSection& section =
      FindObject(scenario.objects, parameters.object, parameters.object_key);
  PickTask task{.object = object, .to = below.name, .nominal_mass = section.mass.value_or(0)};
  const Transform to_top = scenario::TopOf(below);
  task.to_up = NormalOf(to_top);
  task.O_T_goal = scenario::StandingOn(
      to_top, object, Drawn(parameters.place, parameters.spread, scenario.seed, 0));
  task.O_T_object = object.X_WB;
  if (parameters.perception != scenario::FramePose()) {
    const scenario::FramePose error = Drawn({}, parameters.perception, scenario.seed, 1);
    task.object.X_WB = model::Multiply(object.X_WB, error.Matrix());
  }
  task.from = section.on == scenario::kGround ? kFloor : section.on;
  if (task.from.empty()) {
    throw InputError(fmt::format("{}{} stands on nothing; say on which object, or on: {}",
                                 parameters.object_key, object.name, scenario::kGround));
  }
  if (task.from != kFloor) {
    task.from_up = NormalOf(scenario::TopOf(FindObject(objects, task.from, parameters.object_key)));
  }
  return task;
}

std::vector<Grip> GripsOf(const plant::SceneObject& object, const Vector3& up,
                          const GripRoom& room) {
  const Matrix3d O_R_B = model::Orientation(object.X_WB).toRotationMatrix();
  const Vector3d B_up = UpOf(object, O_R_B.transpose() * Vector3d(up.data()));
  const double half = HalfAlong(object, B_up);
  const double height = std::max({0.0, half - (kPalm - room.palm), kTip + room.below - half});
  std::vector<Grip> grips;
  if (height > half - kLeastHold) return grips;
  for (const Closing& closing : ClosingsOf(object, B_up)) {
    if (closing.width > kHandStroke - 2 * room.beside) continue;
    for (const double sign : {1.0, -1.0}) {
      Matrix3d B_R_NE;
      B_R_NE.col(1) = sign * closing.axis;
      B_R_NE.col(2) = -B_up;
      B_R_NE.col(0) = B_R_NE.col(1).cross(B_R_NE.col(2));
      grips.push_back({.B_T_NE = model::Pose(Eigen::Quaterniond(B_R_NE), height * B_up),
                       .B_up = {B_up.x(), B_up.y(), B_up.z()},
                       .width = closing.width});
    }
  }
  return grips;
}

}  // namespace twin::application
