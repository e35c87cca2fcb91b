#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/onboard/int_config.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/robot/link_config.h"

namespace twin::robot {

/// Which body INT moves.
enum class PlantKind : std::uint8_t {
  kMujoco,
  kIdeal,
};

/// A whole emulated robot: INT, plant and link.
struct RobotConfig {
  onboard::IntConfig onboard;
  PlantKind plant_kind = PlantKind::kMujoco;
  plant::MujocoPlantOptions plant;  ///< used by kMujoco
  LinkConfig link;
  JointVector q_start{};   ///< where the arm rests when the run starts, rad
  double clock_ppm = 0;    ///< how much faster INT's clock runs than the run's, in [-1000, 1000]
  std::uint64_t seed = 0;  ///< of link and sensors

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
