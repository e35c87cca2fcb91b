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

/// @param least  share of the bounds: -1 for a pose, 0 for a spread.
scenario::FramePose ReadPose(control::ParameterReader& p, const std::string& key, double least) {
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
constexpr double kHalfTip = 0.011;    // m, half of a fingertip's breadth

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

/// Where along an axis a hand takes the object, object's axes.
std::vector<Vector3d> PlacesOn(const plant::SceneObject& object, const Vector3d& along,
                               const GripPlace& place) {
  if (place.off_centre == 0) return {Vector3d::Zero()};
  const bool is_straight =
      object.shape == plant::ObjectShape::kBox || std::abs(along.z()) > kStands;
  if (!is_straight || place.off_centre + kHalfTip > HalfAlong(object, along)) return {};
  std::vector<Vector3d> places;
  for (const double sign : {1.0, -1.0}) {
    const Vector3d p = sign * place.off_centre * along;
    if (p.dot(Vector3d(place.B_side.data())) >= 0) places.push_back(p);
  }
  return places;
}

}  // namespace

Handling::Handling(control::ParameterReader& p)
    : object(RequiredText(p, "object")),
      perception(ReadPose(p, "perception.spread.", 0)),
      force(p.Quantity("grasp.force", Dimension::kForce, 40, 1, 140)),
      speed(p.Quantity("grasp.speed", Dimension::kVelocity, 0.05, 0.001, 0.1)),
      tolerance(p.Quantity("grasp.tolerance", Dimension::kLength, 0.003, 1e-4, 0.04)),
      tries(static_cast<int>(p.Number("grasp.tries", 3, 1, 10))),
      options(ReadOptions(p)),
      object_key(p.PlaceOf("object")) {}

PutDown::PutDown(control::ParameterReader& p)
    : on(RequiredText(p, "place.on")),
      place(ReadPose(p, "place.", -1)),
      spread(ReadPose(p, "place.spread.", 0)),
      on_key(p.PlaceOf("place.on")) {}

scenario::FramePose ReadPlace(control::ParameterReader& parameters, const std::string& key) {
  return ReadPose(parameters, key + ".", -1);
}

PickTask ObjectOf(const scenario::Scenario& scenario, const Handling& handling) {
  const std::vector<plant::SceneObject> objects = ObjectsOf(scenario.objects, scenario.seed);
  const plant::SceneObject& object = FindObject(objects, handling.object, handling.object_key);
  if (!object.mass || object.shape == plant::ObjectShape::kSphere) {
    throw InputError(fmt::format("{}{} is {}", handling.object_key, object.name,
                                 object.mass ? "a sphere, which does not stay where it is put"
                                             : "fixed to the world; give it a mass"));
  }
  const scenario::ObjectSection& section =
      FindObject(scenario.objects, handling.object, handling.object_key);
  PickTask task{.X_WO = scenario.robot.pose.Matrix(), .object = object};
  task.nominal_mass = section.mass.value_or(0);
  const Transform X_OW = model::Inverse(task.X_WO);
  task.O_T_object = model::Multiply(X_OW, object.X_WB);
  task.object.X_WB = task.O_T_object;
  if (handling.perception != scenario::FramePose()) {
    const scenario::FramePose error = Drawn({}, handling.perception, scenario.seed, 1);
    task.object.X_WB = model::Multiply(task.O_T_object, error.Matrix());
  }
  task.from = section.on == scenario::kGround ? kFloor : section.on;
  if (task.from.empty()) {
    throw InputError(fmt::format("{}{} stands on nothing; say on which object, or on: {}",
                                 handling.object_key, object.name, scenario::kGround));
  }
  if (task.from != kFloor) {
    const plant::SceneObject& below = FindObject(objects, task.from, handling.object_key);
    task.from_up = NormalOf(model::Multiply(X_OW, scenario::TopOf(below)));
  }
  return task;
}

void AddGoal(const scenario::Scenario& scenario, const PutDown& put_down, PickTask& task) {
  const std::vector<plant::SceneObject> objects = ObjectsOf(scenario.objects, scenario.seed);
  const plant::SceneObject& below = FindObject(objects, put_down.on, put_down.on_key);
  const Transform X_OW = model::Inverse(task.X_WO);
  const Transform X_WT = scenario::TopOf(below);
  task.to = below.name;
  task.to_up = NormalOf(model::Multiply(X_OW, X_WT));
  task.O_T_goal = model::Multiply(
      X_OW, scenario::StandingOn(X_WT, task.object,
                                 Drawn(put_down.place, put_down.spread, scenario.seed, 0)));
}

void RequireFingers(const scenario::Scenario& scenario) {
  if (scenario.robot.hand == plant::HandKind::kFrankaHand) return;
  throw InputError(
      fmt::format("application {}: robot.hand has no fingers; say robot: {{hand: franka_hand}}",
                  scenario.application.value().type));
}

std::vector<Grip> GripsOf(const plant::SceneObject& object, const Vector3& up, const GripRoom& room,
                          const GripPlace& place) {
  const Matrix3d O_R_B = model::Orientation(object.X_WB).toRotationMatrix();
  const Vector3d B_up = UpOf(object, O_R_B.transpose() * Vector3d(up.data()));
  const double half = HalfAlong(object, B_up);
  const double height = std::max({0.0, half - (kPalm - room.palm), kTip + room.below - half});
  std::vector<Grip> grips;
  if (height > half - kLeastHold) return grips;
  for (const Closing& closing : ClosingsOf(object, B_up)) {
    if (closing.width > kHandStroke - 2 * room.beside) continue;
    for (const Vector3d& B_p : PlacesOn(object, closing.axis.cross(B_up), place)) {
      for (const double sign : {1.0, -1.0}) {
        Matrix3d B_R_NE;
        B_R_NE.col(1) = sign * closing.axis;
        B_R_NE.col(2) = -B_up;
        B_R_NE.col(0) = B_R_NE.col(1).cross(B_R_NE.col(2));
        grips.push_back({.B_T_NE = model::Pose(Eigen::Quaterniond(B_R_NE), height * B_up + B_p),
                         .B_up = {B_up.x(), B_up.y(), B_up.z()},
                         .width = closing.width});
      }
    }
  }
  return grips;
}

}  // namespace twin::application
