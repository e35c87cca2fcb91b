#include "twin/onboard/loss_monitor.h"

#include <gtest/gtest.h>

namespace twin::onboard::onboard_loss_monitor_test {
namespace {

TEST(LossMonitorTest, StartsWithoutARate) {
  EXPECT_EQ(LossMonitor().success_rate(), 0);
}

TEST(LossMonitorTest, AYoungMotionIsMeasuredByTheCyclesItHasHad) {
  LossMonitor losses;
  for (int i = 0; i < 3; ++i) losses.CountServed();
  losses.CountLost();
  EXPECT_DOUBLE_EQ(losses.success_rate(), 0.75);
}

TEST(LossMonitorTest, LooksAtTheLastHundredCycles) {
  LossMonitor losses;
  for (int i = 0; i < 50; ++i) losses.CountLost();
  for (int i = 0; i < 60; ++i) losses.CountServed();
  EXPECT_DOUBLE_EQ(losses.success_rate(), 0.60);
  for (int i = 0; i < 40; ++i) losses.CountServed();
  EXPECT_DOUBLE_EQ(losses.success_rate(), 1.0);
}

TEST(LossMonitorTest, CountsLossesWithoutABreak) {
  LossMonitor losses;
  for (int i = 0; i < 19; ++i) losses.CountLost();
  EXPECT_EQ(losses.lost_in_row(), 19u);
  losses.CountServed();
  EXPECT_EQ(losses.lost_in_row(), 0u);
}

}  // namespace
}  // namespace twin::onboard::onboard_loss_monitor_test
