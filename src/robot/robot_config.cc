#include "twin/robot/robot_config.h"

#include <algorithm>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/require.h"

namespace twin::robot {

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

}  // namespace twin::robot
