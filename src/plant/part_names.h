#pragma once

#include <map>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

namespace twin::plant {

/// What parts are called: a body of the model by its name, of what is fixed to the world each
/// shape.
struct ModelParts {
  explicit ModelParts(const mjModel& model);

  std::vector<int> of_geom;
  std::map<int, std::string> names;
};

/// By body: whether it moves with the arm, from its first moving link on.
[[nodiscard]] std::vector<bool> MovingBodies(const mjModel& model);

}  // namespace twin::plant
