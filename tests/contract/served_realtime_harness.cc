// A robot at the other end of a wire, served by this project in real time.

#include "contract/served_harness.h"

namespace twin::test {

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return MakeServedHarness(robot, backend::RobotTime::kWall);
  };
  return {{"MujocoPlantServedInRealtime", robot::PlantKind::kMujoco, make},
          {"IdealPlantServedInRealtime", robot::PlantKind::kIdeal, make}};
}

}  // namespace twin::test
