#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/panel.h"
#include "twin/core/time.h"
#include "twin/onboard/base_controller.h"
#include "twin/onboard/onboard_config.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/robot/link_config.h"

namespace twin::robot {

/// Which body INT moves.
enum class PlantKind : std::uint8_t {
  kMujoco,
  kIdeal,
};

/// Somebody's hand at the robot, at a time of its own clock.
struct PanelEvent {
  Duration at{};  ///< of the robot's clock, whose state k is k ms; before the cycle that follows
  PanelAction action{};
  bool operator==(const PanelEvent&) const = default;
};

/// A whole emulated robot: INT, plant and link.
struct RobotConfig {
  onboard::OnboardConfig onboard;
  PlantKind plant_kind = PlantKind::kMujoco;
  plant::MujocoPlantOptions plant;  ///< used by kMujoco
  onboard::BaseConfig base;         ///< of the mobile base in `plant`; of no meaning without one
  LinkConfig link;
  JointVector q_start{};          ///< where the arm rests when the run starts, rad
  std::vector<PanelEvent> panel;  ///< in order of time
  double clock_ppm = 0;  ///< how much faster INT's clock runs than the run's, in [-1000, 1000]
  /// Losses in a row under which the robot itself sees to it that what it is commanded keeps the
  /// limits (CommandKeeper), in [0, 100]; absent, as on every real one: it takes what comes.
  std::optional<int> viability{};
  std::uint64_t seed = 0;  ///< of link and sensors

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
