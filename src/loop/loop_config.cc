#include "twin/loop/loop_config.h"

#include "twin/core/error.h"
#include "twin/core/require.h"

namespace twin::loop {

void TickConfig::Validate(control::CommandInterface interface) const {
  RequireInRange("tick: lambda", lambda, 1e-9, 1);
  RequireInRange("tick: source_rate_hz", source_rate_hz, 1, 1000);
  RequireInRange("tick: finish_tolerance_rad", finish_tolerance_rad, 1e-9, 1e-2);
  if (generator == Generator::kJoint && interface != control::CommandInterface::kJointPosition) {
    throw InputError(
        "tick.generator: joint makes positions and does not go with motion.interface: "
        "joint_velocity; say none, or leave it out");
  }
}

void ControllerLoopConfig::Validate() const {
  RequireInRange("controller: rate_hz", rate_hz, 1, 1000);
  RequireInRange("controller: clock_ppm", clock_ppm, -1000, 1000);
  RequireInRange("controller: phase (ms)", ToSeconds(phase) * 1e3, 0, 10000);
}

}  // namespace twin::loop
