#include "twin/render/body_names.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

namespace twin::render {

std::vector<std::string> BodyNames(const mjModel_& model) {
  std::vector<std::string> names;
  for (int body = 0; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    names.push_back(name == nullptr || *name == 0 ? fmt::format("body {}", body) : name);
  }
  return names;
}

}  // namespace twin::render
