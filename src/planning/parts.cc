#include "planning/parts.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/core/error.h"

namespace twin::planning {
namespace {

using Vector = Eigen::Vector3d;

Vector At(const mjtNum* triples, int index) {
  return {triples[3 * index], triples[3 * index + 1], triples[3 * index + 2]};
}

std::string NameOr(const mjModel& model, int type, int id, std::string_view kind) {
  const char* name = mj_id2name(&model, type, id);
  return name != nullptr && *name != '\0' ? std::string(name) : fmt::format("{} {}", kind, id);
}

bool IsFreeBody(const mjModel& model, int body) {
  return model.body_jntnum[body] == 1 && model.jnt_type[model.body_jntadr[body]] == mjJNT_FREE;
}

/// Positions of the arm's axes, and the distances from one to the next along the arm.
struct Axes {
  std::array<Vector, kJoints> anchor;
  std::array<Vector, kJoints> direction;

  Axes(const plant::CompiledModel& compiled, const mjData& data) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      anchor[i] = At(data.xanchor, compiled.arm[i]);
      direction[i] = At(data.xaxis, compiled.arm[i]);
    }
  }
  [[nodiscard]] double FromAxis(std::size_t i, const Vector& p) const {
    return direction[i].cross(p - anchor[i]).norm();
  }
};

}  // namespace

PartNames::PartNames(const mjModel& model) {
  for (int body = 1; body < model.nbody; ++body) {
    names_[body] = NameOr(model, mjOBJ_BODY, body, "body");
  }
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    of_shape_.push_back(body > 0 ? body : model.nbody + geom);
    if (body == 0) names_[of_shape_.back()] = NameOr(model, mjOBJ_GEOM, geom, "shape");
  }
}

int PartNames::Find(const std::string& name) const {
  std::string known;
  for (const auto& [part, known_name] : names_) {
    if (known_name == name) return part;
    known += (known.empty() ? "" : ", ") + known_name;
  }
  throw InputError(fmt::format("planning: the scene has no part '{}'; it has: {}", name, known));
}

std::vector<int> JointsBefore(const plant::CompiledModel& compiled) {
  const mjModel& model = *compiled.model;
  std::vector<int> count(model.nbody, 0);
  for (int body = 1; body < model.nbody; ++body) {
    count[body] = count[model.body_parentid[body]];
    for (const int joint : compiled.arm) count[body] += model.jnt_bodyid[joint] == body ? 1 : 0;
  }
  return count;
}

int FreeJointOf(const mjModel& model, const std::string& body) {
  std::string free_ones;
  for (int i = 1; i < model.nbody; ++i) {
    if (!IsFreeBody(model, i)) continue;
    const std::string name = NameOr(model, mjOBJ_BODY, i, "body");
    if (name == body) return model.body_jntadr[i];
    free_ones += (free_ones.empty() ? "" : ", ") + name;
  }
  throw InputError(fmt::format("planning: '{}' is no body of the scene that can be moved; {}", body,
                               free_ones.empty() ? "none of this scene has a <freejoint>"
                                                 : "those with a <freejoint> are: " + free_ones));
}

JointVector ReachOf(const plant::CompiledModel& compiled, const mjData& data,
                    const std::vector<int>& joints_before, int held) {
  const mjModel& model = *compiled.model;
  const Axes axes(compiled, data);
  JointVector reach{};
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    const bool is_held = held >= 0 && model.body_rootid[body] == held;
    const int moved_by = is_held ? static_cast<int>(kJoints) : joints_before[body];
    if (moved_by == 0) continue;
    // From the joint nearest to the shape down to the base.
    const Vector centre = At(data.geom_xpos, geom);
    const auto last = static_cast<std::size_t>(moved_by - 1);
    double beyond = model.geom_rbound[geom];
    reach[last] = std::max(reach[last], axes.FromAxis(last, centre) + beyond);
    beyond += (centre - axes.anchor[last]).norm();
    for (std::size_t i = last; i-- > 0;) {
      const Vector& next = axes.anchor[i + 1];
      reach[i] = std::max(reach[i], axes.FromAxis(i, next) + beyond);
      beyond += (next - axes.anchor[i]).norm();
    }
  }
  return reach;
}

}  // namespace twin::planning
