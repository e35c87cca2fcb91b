#include "contract/backend_harness.h"
#include "support/panda_limits.h"

namespace twin::test {

robot::RobotConfig HarnessRobot(robot::PlantKind plant_kind) {
  robot::RobotConfig config;
  config.onboard.limits = PandaLimits();
  config.onboard.cartesian = PandaCartesianLimits();
  if (plant_kind == robot::PlantKind::kMujoco) {
    config.onboard.rotor_inertia = {0.6, 0.6, 0.46, 0.46, 0.2, 0.2, 0.2};
  }
  config.plant_kind = plant_kind;
  config.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  config.plant.hand = plant::HandKind::kNone;
  config.q_start = kHarnessStart;
  return config;
}

}  // namespace twin::test
