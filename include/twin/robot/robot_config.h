#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/time.h"
#include "twin/faults/message_fate.h"
#include "twin/onboard/base_controller.h"
#include "twin/onboard/onboard_config.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/plant/plant.h"

namespace twin::robot {

/// Longest delay of a message; longer ones count as lost, since a successor would overtake them and
/// they would be dropped on arrival.
inline constexpr Duration kLongestOnTheWay = 255 * kCycle;

/// The link between the robot and the workstation.
struct LinkConfig {
  faults::DirectionConfig state;    ///< robot -> workstation
  faults::DirectionConfig command;  ///< workstation -> robot
  /// INT's own processing: a command counts for cycle k only if it arrived by t_k - d_INT.
  Duration d_INT = std::chrono::microseconds(100);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// INT ends a motion after 20 commands lost in a row.
inline constexpr Duration kLongestCatchUp = 19 * kCycle;

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
  std::uint16_t protocol = 5;  ///< version of the Franka Control Interface that it speaks: 5 or 10
  PlantKind plant_kind = PlantKind::kMujoco;
  plant::MujocoPlantOptions plant;  ///< used by kMujoco
  onboard::BaseConfig base;         ///< of the mobile base in `plant`; unused without one
  LinkConfig link;
  JointVector q_start{};          ///< initial position, at rest, rad
  std::vector<PanelEvent> panel;  ///< sorted by time
  double clock_ppm = 0;           ///< drift of INT's clock against the run's, in [-1000, 1000]
  /// On the wall clock: cycles that the host made late by at most this are executed at once,
  /// without commands, as WallClockRobot says; [0, 19 ms].
  Duration catch_up{};
  /// Consecutive losses under which the robot itself makes commands keep the limits
  /// (CommandKeeper), in [0, 100]; absent, as on every real robot: commands are not changed.
  std::optional<int> viability{};
  std::uint64_t seed = 0;  ///< of link and sensors

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

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
