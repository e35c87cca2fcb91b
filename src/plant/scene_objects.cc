#include "plant/scene_objects.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "plant/model_builder.h"
#include "twin/core/error.h"
#include "twin/core/setting.h"

namespace twin::plant {
namespace {

constexpr double kLeastSize = 1e-3;  // m
constexpr double kMostSize = 10;
constexpr double kLeastMass = 1e-3;  // kg
constexpr double kMostMass = 100;
constexpr double kMostFriction = 10;

/// A shape in the engine's terms.
struct Geometry {
  int type = mjGEOM_BOX;
  Vector3 size{};            ///< as geom_size
  double bound = 0;          ///< radius of the sphere around it, m
  Vector3 inertia_per_kg{};  ///< about its centre, m^2
};

Geometry GeometryOf(const SceneObject& object) {
  const Vector3 h{object.size[0] / 2, object.size[1] / 2, object.size[2] / 2};
  switch (object.shape) {
    case ObjectShape::kBox:
      return {.type = mjGEOM_BOX,
              .size = h,
              .bound = std::hypot(h[0], h[1], h[2]),
              .inertia_per_kg = {(h[1] * h[1] + h[2] * h[2]) / 3, (h[0] * h[0] + h[2] * h[2]) / 3,
                                 (h[0] * h[0] + h[1] * h[1]) / 3}};
    case ObjectShape::kCylinder: {
      const double across = h[0] * h[0] / 4 + h[2] * h[2] / 3;
      return {.type = mjGEOM_CYLINDER,
              .size = {h[0], h[2], 0},
              .bound = std::hypot(h[0], h[2]),
              .inertia_per_kg = {across, across, h[0] * h[0] / 2}};
    }
    case ObjectShape::kSphere: {
      const double any = 0.4 * h[0] * h[0];
      return {.type = mjGEOM_SPHERE,
              .size = {h[0], 0, 0},
              .bound = h[0],
              .inertia_per_kg = {any, any, any}};
    }
  }
  return {};
}

/// Position, then the unit quaternion w x y z.
std::array<mjtNum, 7> PoseOf(const Transform& X) {
  const std::array<mjtNum, 9> R{X[0], X[4], X[8], X[1], X[5], X[9], X[2], X[6], X[10]};
  std::array<mjtNum, 7> pose{X[12], X[13], X[14]};
  mju_mat2Quat(pose.data() + 3, R.data());
  return pose;
}

void SetShape(const SceneObject& object, mjModel& model) {
  const int body = mj_name2id(&model, mjOBJ_BODY, object.name.c_str());
  TWIN_CHECK(body > 0 && model.body_geomnum[body] == 1);
  const int geom = model.body_geomadr[body];
  const Geometry geometry = GeometryOf(object);
  model.geom_type[geom] = geometry.type;
  std::copy(geometry.size.begin(), geometry.size.end(), model.geom_size + 3 * geom);
  model.geom_rbound[geom] = geometry.bound;
  model.geom_friction[3 * geom] = object.friction;
  for (std::size_t i = 0; i < 4; ++i) {
    model.geom_rgba[4 * geom + i] = static_cast<float>(object.rgba[i]);
  }
  const double mass = object.mass.value_or(0);
  model.body_mass[body] = mass;
  for (std::size_t i = 0; i < 3; ++i) {
    model.body_inertia[3 * body + i] = mass * geometry.inertia_per_kg[i];
  }
  std::fill_n(model.body_ipos + 3 * body, 3, 0);
  mju_unit4(model.body_iquat + 4 * body);
  const std::array<mjtNum, 7> pose = PoseOf(object.X_WB);
  std::copy_n(pose.begin(), 3, model.body_pos + 3 * body);
  std::copy_n(pose.begin() + 3, 4, model.body_quat + 4 * body);
  if (!object.mass) return;
  const int qpos = model.jnt_qposadr[model.body_jntadr[body]];
  std::copy(pose.begin(), pose.end(), model.qpos0 + qpos);
  std::copy(pose.begin(), pose.end(), model.qpos_spring + qpos);
}

void RequireName(const SceneObject& object) {
  const auto is_letter = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  if (!object.name.empty() && object.name.size() <= 64 &&
      std::ranges::all_of(object.name, is_letter)) {
    return;
  }
  throw InputError(fmt::format(
      "object \"{}\": that is no name; use 1 to 64 letters, digits and '_'", object.name));
}

void RequireShape(const SceneObject& object) {
  const auto field = [&](std::string_view name) {
    return fmt::format("object {}: {}", object.name, name);
  };
  for (const double size : object.size) RequireInRange(field("size"), size, kLeastSize, kMostSize);
  const bool is_round = object.shape != ObjectShape::kBox;
  const bool is_ball = object.shape == ObjectShape::kSphere;
  if ((is_round && object.size[0] != object.size[1]) ||
      (is_ball && object.size[0] != object.size[2])) {
    throw InputError(fmt::format("object {}: size {} x {} x {} m; of a {} {} must be the diameter",
                                 object.name, object.size[0], object.size[1], object.size[2],
                                 is_ball ? "sphere" : "cylinder",
                                 is_ball ? "all three" : "the first two, equal,"));
  }
  if (object.mass) RequireInRange(field("mass"), *object.mass, kLeastMass, kMostMass);
  RequireInRange(field("friction"), object.friction, 0, kMostFriction);
  for (const double share : object.rgba) RequireInRange(field("colour"), share, 0, 1);
  if (!IsRigid(object.X_WB)) {
    throw InputError(fmt::format("object {}: its pose is no rigid transform", object.name));
  }
}

}  // namespace

void Validate(const std::vector<SceneObject>& objects) {
  for (auto object = objects.begin(); object != objects.end(); ++object) {
    RequireName(*object);
    RequireShape(*object);
    if (std::find_if(objects.begin(), object, [&](const SceneObject& other) {
          return other.name == object->name;
        }) == object) {
      continue;
    }
    throw InputError(fmt::format("object {}: there are two of that name", object->name));
  }
}

std::string ObjectsMjcf(const std::vector<SceneObject>& objects) {
  std::string text;
  for (const SceneObject& object : objects) {
    text += fmt::format(
        "<body name=\"{0}\">{1}<geom name=\"{0}\" class=\"twin_object\" type=\"box\" "
        "size=\"0.01 0.01 0.01\" mass=\"1\"/></body>\n",
        object.name, object.mass ? fmt::format("<freejoint name=\"{}\"/>", object.name) : "");
  }
  return text;
}

std::string ObjectsKey(const std::vector<SceneObject>& objects) {
  std::string key;
  for (const SceneObject& object : objects) {
    key += fmt::format("{} {};", object.mass ? "free" : "fixed", object.name);
  }
  return key;
}

void ShapeObjects(const std::vector<SceneObject>& objects, mjModel& model) {
  if (objects.empty()) return;
  for (const SceneObject& object : objects) SetShape(object, model);
  // A cylinder on a flat face has one contact in the engine's general algorithm, and rocks.
  if (std::ranges::any_of(objects, [](const SceneObject& object) {
        return object.shape == ObjectShape::kCylinder;
      })) {
    model.opt.enableflags |= mjENBL_MULTICCD;
  }
  // Keeps the scale of rendering, which a scene may have set.
  const auto statistic = model.stat;
  const DataPointer data(mj_makeData(&model));
  mj_setConst(&model, data.get());
  model.stat.extent = statistic.extent;
  model.stat.meansize = statistic.meansize;
  std::copy_n(statistic.center, 3, model.stat.center);
}

}  // namespace twin::plant
