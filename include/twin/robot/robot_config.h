#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/onboard/int_config.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/rt/delay_model.h"

namespace twin::robot {

/// The way between the robot and the workstation.
struct LinkConfig {
  rt::DelayModel state_delay;    ///< robot -> workstation
  rt::DelayModel command_delay;  ///< workstation -> robot
  double state_loss = 0;         ///< probability that a state is lost, in [0, 1], independent
  double command_loss = 0;       ///< probability that a command is lost, in [0, 1], independent
  /// INT's own processing: a command counts for cycle k only if it arrived by t_k - d_INT.
  Duration d_INT = std::chrono::microseconds(100);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

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
  std::uint64_t seed = 0;  ///< of link and sensors

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
