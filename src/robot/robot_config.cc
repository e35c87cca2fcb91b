#include "twin/robot/robot_config.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::robot {
namespace {

void RequireProbability(const char* field, double value) {
  if (value >= 0 && value <= 1) return;
  throw InputError(fmt::format("link: {} is {}; it is a probability, in [0, 1]", field, value));
}

}  // namespace

void LinkConfig::Validate() const {
  RequireProbability("state_loss", state_loss);
  RequireProbability("command_loss", command_loss);
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
    throw InputError(
        fmt::format("robot: start position of joint {} is {} rad; it must lie in [{}, {}]", i + 1,
                    q_start[i], onboard.limits.q_min[i], onboard.limits.q_max[i]));
  }
}

}  // namespace twin::robot
