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

/// Kind of plant that INT moves.
enum class PlantKind : std::uint8_t {
  kMujoco,
  kIdeal,
};

/// A panel action at a time of the robot's clock.
struct PanelEvent {
  Duration at{};  ///< state k is at k ms; acts before the next cycle
  PanelAction action{};
  bool operator==(const PanelEvent&) const = default;
};

/// Configuration of an emulated robot: INT, plant and link.
struct RobotConfig {
  onboard::OnboardConfig onboard;
  PlantKind plant_kind = PlantKind::kMujoco;
  plant::MujocoPlantOptions plant;  ///< used by kMujoco
  onboard::BaseConfig base;         ///< of the mobile base in `plant`; unused without one
  LinkConfig link;
  JointVector q_start{};          ///< initial position, at rest, rad
  std::vector<PanelEvent> panel;  ///< sorted by time
  double clock_ppm = 0;           ///< drift of INT's clock against the run's, in [-1000, 1000]
  /// Consecutive losses under which the robot itself makes commands keep the limits
  /// (CommandKeeper), in [0, 100]; absent, as on every real robot: commands are not changed.
  std::optional<int> viability{};
  std::uint64_t seed = 0;  ///< of link and sensors

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::robot
