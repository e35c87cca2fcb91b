// A robot at the other end of a wire, served by this project in real time.

#include "contract/served_harness.h"
#include "contract/urgent.h"

namespace twin::test {

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return MakeServedHarness(robot, backend::RobotTime::kWall);
  };
  return {{"MujocoPlantServedInRealtime", robot::PlantKind::kMujoco, make, false, kUrgentHere},
          {"IdealPlantServedInRealtime", robot::PlantKind::kIdeal, make, false, kUrgentHere}};
}

}  // namespace twin::test
