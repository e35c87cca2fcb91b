#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/plant/observers.h"

namespace twin::plant {

/// Names of parts: that of a body, or, for what is fixed to the world, that of each shape.
struct ModelParts {
  explicit ModelParts(const mjModel& model);

  std::vector<int> of_geom;
  std::map<int, std::string> names;
};

/// The root body of the robot: the arm's base, or the mobile base below it. -1 without an arm.
/// @param prefix  of the names of its bodies, as TruthProbe::prefix().
[[nodiscard]] int RobotRoot(const mjModel& model, const std::string& prefix = {});

/// By body: whether it moves with the arm, from its first moving link on, or with a mobile base,
/// except for the wheels, which always touch the ground.
[[nodiscard]] std::vector<bool> MovingBodies(const mjModel& model, const std::string& prefix = {});

/// The deepest contact in `data` of bodies that move with an arm. @param moves  as MovingBodies().
[[nodiscard]] std::optional<ArmOverlap> DeepestOverlap(const mjModel& model, const mjData& data,
                                                       const std::vector<bool>& moves);

}  // namespace twin::plant
