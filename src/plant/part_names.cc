#include "plant/part_names.h"

#include <fmt/format.h>

namespace twin::plant {
namespace {

/// The arm's base, and the link on its first joint, the root of all moving links.
constexpr const char* kArmBase = "panda_link0";
constexpr const char* kFirstMovingLink = "panda_link1";

std::string NameOr(const mjModel& model, int type, int id, const char* kind) {
  const char* name = mj_id2name(&model, type, id);
  return name != nullptr && *name != '\0' ? std::string(name) : fmt::format("{} {}", kind, id);
}

}  // namespace

ModelParts::ModelParts(const mjModel& model) {
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    const int part = body > 0 ? body : model.nbody + geom;
    of_geom.push_back(part);
    names[part] = body > 0 ? NameOr(model, mjOBJ_BODY, body, "body")
                           : NameOr(model, mjOBJ_GEOM, geom, "shape");
  }
}

int RobotRoot(const mjModel& model, const std::string& prefix) {
  const int arm = mj_name2id(&model, mjOBJ_BODY, (prefix + kArmBase).c_str());
  return arm < 0 ? -1 : model.body_rootid[arm];
}

// A body follows its parent in the order.
std::vector<bool> MovingBodies(const mjModel& model, const std::string& prefix) {
  std::vector<bool> moves(model.nbody, false);
  const int first = mj_name2id(&model, mjOBJ_BODY, (prefix + kFirstMovingLink).c_str());
  const int root = RobotRoot(model, prefix);
  const bool has_base = root >= 0 && model.body_jntnum[root] > 0;
  for (int body = 1; body < model.nbody; ++body) {
    const bool is_wheel = has_base && body != first && model.body_parentid[body] == root &&
                          model.body_jntnum[body] > 0;
    moves[body] = body == first || (has_base && body == root) ||
                  (moves[model.body_parentid[body]] && !is_wheel);
  }
  return moves;
}

}  // namespace twin::plant
