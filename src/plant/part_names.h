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

/// The body that carries the whole robot: the arm's base, or the mobile base below it. -1: there is
/// no arm.
[[nodiscard]] int RobotRoot(const mjModel& model);

/// By body: whether it moves with the arm, from its first moving link on; with a mobile base also
/// the base, all but the wheels, which always touch.
[[nodiscard]] std::vector<bool> MovingBodies(const mjModel& model);

}  // namespace twin::plant
