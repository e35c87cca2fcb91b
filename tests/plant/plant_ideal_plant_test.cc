#include "twin/plant/ideal_plant.h"

#include <gtest/gtest.h>

namespace twin::plant {
namespace {

TEST(IdealPlantTest, RestsWhereItWasReset) {
  IdealPlant plant;
  plant.Step({.tau = {1}, .q_d = {2}, .dq_d = {3}, .ddq_d = {4}});
  plant.Reset({0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7});
  EXPECT_EQ(plant.sensors().q, (JointVector{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}));
  EXPECT_EQ(plant.sensors().theta, plant.sensors().q);
  EXPECT_EQ(plant.sensors().dq, JointVector{});
  EXPECT_EQ(plant.sensors().tau_J, JointVector{});
}

TEST(IdealPlantTest, DoesExactlyWhatIsDesired) {
  IdealPlant plant;
  plant.Reset({});
  const JointDrive drive{.tau = {5, 6}, .q_d = {0.1, -0.2}, .dq_d = {0.3, 0.4}, .ddq_d = {9, 9}};
  plant.Step(drive);
  EXPECT_EQ(plant.sensors().q, drive.q_d);
  EXPECT_EQ(plant.sensors().dq, drive.dq_d);
  EXPECT_EQ(plant.sensors().tau_J, drive.tau);
  EXPECT_EQ(plant.sensors().theta, drive.q_d);
  EXPECT_EQ(plant.sensors().dtheta, drive.dq_d);
}

}  // namespace
}  // namespace twin::plant
