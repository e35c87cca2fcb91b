#include "plant/part_names.h"

#include <fmt/format.h>

namespace twin::plant {
namespace {

/// The link that the arm's first joint moves; all that hangs on it is the arm.
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

// A body comes after its parent.
std::vector<bool> MovingBodies(const mjModel& model) {
  std::vector<bool> moves(model.nbody, false);
  const int first = mj_name2id(&model, mjOBJ_BODY, kFirstMovingLink);
  for (int body = 1; body < model.nbody; ++body) {
    moves[body] = body == first || moves[model.body_parentid[body]];
  }
  return moves;
}

}  // namespace twin::plant
