#include "twin/robot/robot_config.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/model/mass_properties.h"
#include "twin/plant/ideal_plant.h"

namespace twin::robot {
namespace {

void ValidateDirection(const faults::DirectionConfig& direction, std::string_view where) {
  direction.Validate(where);
  if (direction.reorder_by <= kLongestOnTheWay) return;
  throw InputError(fmt::format(
      "{}.reorder_by is {} ms; it must lie in [0, {}] ms: what takes longer on the way is lost",
      where, ToSeconds(direction.reorder_by) * 1e3, ToSeconds(kLongestOnTheWay) * 1e3));
}

}  // namespace

void LinkConfig::Validate() const {
  ValidateDirection(state, "link.state");
  ValidateDirection(command, "link.command");
  if (d_INT < Duration::zero() || d_INT >= kCycle) {
    throw InputError(
        fmt::format("link.d_INT is {} us; it must lie in [0, 1000) us", ToSeconds(d_INT) * 1e6));
  }
}

void RobotConfig::Validate() const {
  onboard.Validate();
  link.Validate();
  if (plant.base) {
    base.Validate();
    if (plant_kind == PlantKind::kIdeal) {
      throw InputError("robot.base: the ideal plant has no mobile base; say kind: mujoco");
    }
  }
  RequireInRange("robot.clock_ppm", clock_ppm, -1000, 1000);
  RequireInRange("robot.catch_up (s)", ToSeconds(catch_up), 0, ToSeconds(kLongestCatchUp));
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (q_start[i] >= onboard.limits.q_min[i] && q_start[i] <= onboard.limits.q_max[i]) continue;
    throw InputError(fmt::format("robot.q_start: joint {} is at {} rad; it must lie in [{}, {}]",
                                 i + 1, q_start[i], onboard.limits.q_min[i],
                                 onboard.limits.q_max[i]));
  }
  const auto earlier = [](const PanelEvent& a, const PanelEvent& b) { return a.at < b.at; };
  if (!std::ranges::is_sorted(panel, earlier)) {
    throw InputError("robot.panel: its events must be in order of time");
  }
}

MadePlant MakePlant(const RobotConfig& config) {
  if (config.plant_kind == PlantKind::kIdeal) {
    const setting::Load& load = config.plant.load;
    const model::Payload there =
        model::Combine(config.onboard.end_effector, {load.m_load, load.F_x_Cload, load.I_load});
    return {std::make_unique<plant::IdealPlant>(there, config.plant.hand, config.onboard.arm),
            nullptr, "ideal plant (q = q_d)"};
  }
  std::unique_ptr<plant::MujocoPlant> plant = plant::MujocoPlant::Create(config.plant);
  plant::MujocoPlant* engine = plant.get();
  return {std::move(plant), engine, "MuJoCo plant"};
}

}  // namespace twin::robot
