#include "application/pick.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/scenario/objects.h"

namespace twin::application {
namespace {

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
scenario::FramePose Drawn(const scenario::FramePose& pose, const scenario::FramePose& spread,
                          std::uint64_t seed) {
  const Random random(seed, RandomStream::kPlace);
  scenario::FramePose drawn = pose;
  for (std::uint32_t i = 0; i < 3; ++i) {
    drawn.position[i] += spread.position[i] * (2 * random.Uniform(0, i) - 1);
    drawn.rpy[i] += spread.rpy[i] * (2 * random.Uniform(0, 3 + i) - 1);
  }
  return drawn;
}

Vector3 NormalOf(const Transform& top) {
  return {top[8], top[9], top[10]};
}

}  // namespace

PickParameters::PickParameters(control::ParameterReader& p)
    : object(RequiredText(p, "object")),
      on(RequiredText(p, "place.on")),
      place(ReadPlace(p, "place.", -1)),
      spread(ReadPlace(p, "place.spread.", 0)),
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
  PickTask task{.object = object, .to = below.name};
  const Transform to_top = scenario::TopOf(below);
  task.to_up = NormalOf(to_top);
  task.O_T_goal = scenario::StandingOn(to_top, object,
                                       Drawn(parameters.place, parameters.spread, scenario.seed));
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

double NominalMass(const scenario::Scenario& scenario, const std::string& object) {
  return FindObject(scenario.objects, object, "").mass.value_or(0);
}

}  // namespace twin::application
