// Memory of a robot that runs for long: bounded, and flat.

#include <chrono>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "robot/robot_fixture.h"
#include "support/effort.h"

namespace twin::robot::robot_memory_test {
namespace {

/// Resident memory of this process, bytes.
std::int64_t Resident() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t total = 0;
  std::int64_t resident = 0;
  statm >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

TEST(RobotMemoryTest, StaysFlatOverTenSimulatedMinutes) {
  const RobotConfig config = test::PandaRobot();
  rt::EventQueue events;
  test::Deaf deaf;
  Robot robot(config, plant::MujocoPlant::Create(config.plant), events, deaf, nullptr);
  robot.Begin();
  const auto run_until = [&](Time until) {
    while (events.Now() < until) ASSERT_TRUE(events.RunNext());
  };
  run_until(Time(std::chrono::seconds(5)));
  const std::int64_t before = Resident();
  run_until(Time(std::chrono::seconds(test::Repetitions(600))));
  const std::int64_t after = Resident();
  RecordProperty("resident_bytes", std::to_string(after));
  EXPECT_LE(after - before, 512 * 1024) << "grew from " << before << " to " << after;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(after, 150'000'000);
#endif
}

}  // namespace
}  // namespace twin::robot::robot_memory_test
