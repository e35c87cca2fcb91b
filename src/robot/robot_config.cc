#include "twin/robot/robot_config.h"

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/require.h"

namespace twin::robot {

void LinkConfig::Validate() const {
  RequireInRange("link: state_loss", state_loss, 0, 1);
  RequireInRange("link: command_loss", command_loss, 0, 1);
  if (d_INT < Duration::zero() || d_INT >= kCycle) {
    throw InputError(
        fmt::format("link: d_INT is {} us; it must lie in [0, 1000) us", ToSeconds(d_INT) * 1e6));
  }
}

void RobotConfig::Validate() const {
  onboard.Validate();
  link.Validate();
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (q_start[i] >= onboard.limits.q_min[i] && q_start[i] <= onboard.limits.q_max[i]) continue;
    throw InputError(fmt::format("robot.q_start: joint {} is at {} rad; it must lie in [{}, {}]",
                                 i + 1, q_start[i], onboard.limits.q_min[i],
                                 onboard.limits.q_max[i]));
  }
}

}  // namespace twin::robot
