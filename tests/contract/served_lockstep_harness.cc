// A robot at the other end of a wire, served by this project in lockstep.

#include "contract/served_harness.h"

namespace twin::test {

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return MakeServedHarness(robot, backend::RobotTime::kStates);
  };
  return {{"MujocoPlantServedInLockstep", robot::PlantKind::kMujoco, make, true},
          {"IdealPlantServedInLockstep", robot::PlantKind::kIdeal, make, true}};
}

}  // namespace twin::test
