// A gripper that nobody commands for longer than 2^31 cycles, 24.9 days.
#include "twin/onboard/gripper.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace twin::onboard::onboard_gripper_days_test {
namespace {

constexpr std::int64_t kDays = (std::int64_t{1} << 31) + 1000;  // cycles
constexpr int kSettled = 2000;                                  // cycles

HandDrive CycleFor(Gripper& gripper, const HandSensors& sensors, std::int64_t cycles) {
  HandDrive drive;
  for (std::int64_t i = 0; i < cycles; ++i) drive = gripper.Cycle(sensors);
  return drive;
}

TEST(GripperDaysTest, PushesAgainstWhoMovesItsFingers) {
  Gripper gripper({.width = 0.05, .dwidth = 0, .force = 0});
  const HandSensors moved{.width = 0.048, .dwidth = 0, .force = 0};
  const double at_first = CycleFor(gripper, moved, kSettled).force;
  EXPECT_GT(at_first, 1);
  EXPECT_EQ(CycleFor(gripper, moved, kDays).force, at_first);
}

TEST(GripperDaysTest, KnowsThatItHoldsAnObject) {
  Gripper gripper({.width = 0.05, .dwidth = 0, .force = 0});
  const auto start = gripper.Start(hand::Grasp{
      .width = 0.05, .speed = 0.05, .force = 20, .epsilon_inner = 0.005, .epsilon_outer = 0.005});
  const HandSensors pressing{.width = 0.05, .dwidth = 0, .force = -20};
  const double at_first = CycleFor(gripper, pressing, kSettled).force;
  EXPECT_EQ(gripper.Outcome(start.ticket), HandResult::kSuccess);
  EXPECT_TRUE(gripper.state().is_grasped);
  EXPECT_EQ(CycleFor(gripper, pressing, kDays).force, at_first);
  EXPECT_TRUE(gripper.state().is_grasped);
}

}  // namespace
}  // namespace twin::onboard::onboard_gripper_days_test
