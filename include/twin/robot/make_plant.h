#pragma once

#include <memory>
#include <string>

#include "twin/plant/mujoco_plant.h"
#include "twin/plant/plant.h"
#include "twin/robot/robot_config.h"

namespace twin::robot {

/// The body a robot's configuration asks for, and what is told of it.
struct MadePlant {
  std::unique_ptr<plant::Plant> plant;
  plant::MujocoPlant* engine = nullptr;  ///< the same, when it is MuJoCo's; null: the ideal plant
  std::string name;                      ///< for people
};

/// Makes it: MuJoCo's, or the ideal plant. What hangs on the flange is what is really there,
/// whatever INT is told of it.
/// @throws InputError, EnvironmentError as plant::MujocoPlant::Create.
[[nodiscard]] MadePlant MakePlant(const RobotConfig& config);

}  // namespace twin::robot
