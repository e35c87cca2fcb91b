#pragma once

#include <memory>
#include <string>

#include "twin/plant/mujoco_plant.h"
#include "twin/plant/plant.h"
#include "twin/robot/robot_config.h"

namespace twin::robot {

/// The plant of a robot's configuration.
struct MadePlant {
  std::unique_ptr<plant::Plant> plant;
  plant::MujocoPlant* engine = nullptr;  ///< the MuJoCo plant; null for the ideal one
  std::string name;                      ///< for messages
};

/// Creates the MuJoCo or the ideal plant. It carries the configured bodies on the flange,
/// independent of those set in INT.
/// @throws InputError, EnvironmentError as plant::MujocoPlant::Create.
[[nodiscard]] MadePlant MakePlant(const RobotConfig& config);

}  // namespace twin::robot
