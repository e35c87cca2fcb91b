#include "twin/plant/ideal_plant.h"

#include <gtest/gtest.h>

#include "twin/model/arm_model.h"

namespace twin::plant::plant_ideal_plant_test {
namespace {

constexpr model::Payload kHand{.m = 0.73, .F_x_C = {-0.01, 0, 0.03}, .I = {}};

TEST(IdealPlantTest, RestsWhereItWasReset) {
  IdealPlant plant(kHand);
  plant.Step({.tau = {1}, .q_d = {2}, .dq_d = {3}, .ddq_d = {4}});
  const JointVector q{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
  plant.Reset(q);
  EXPECT_EQ(plant.sensors().q, q);
  EXPECT_EQ(plant.sensors().theta, q);
  EXPECT_EQ(plant.sensors().dq, JointVector{});
  const JointVector g = model::ArmModel::Panda().Gravity(q, kHand);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(plant.sensors().tau_J[i], g[i], 1e-12);
}

TEST(IdealPlantTest, DoesExactlyWhatIsDesired) {
  IdealPlant plant;
  plant.Reset({});
  const JointDrive drive{.tau = {5, 6}, .q_d = {0.1, -0.2}, .dq_d = {0.3, 0.4}, .ddq_d = {9, 9}};
  plant.Step(drive);
  EXPECT_EQ(plant.sensors().q, drive.q_d);
  EXPECT_EQ(plant.sensors().dq, drive.dq_d);
  EXPECT_EQ(plant.sensors().theta, drive.q_d);
  EXPECT_EQ(plant.sensors().dtheta, drive.dq_d);
}

TEST(IdealPlantTest, ItsTorqueIsThatOfItsMotionWhateverIsCommanded) {
  IdealPlant plant(kHand);
  JointDrive drive{.tau = {50, -50}, .q_d = {0, -0.8, 0, -2.4}, .dq_d = {1, 0.5}, .ddq_d = {3}};
  plant.Step(drive);
  const JointVector tau_J = plant.sensors().tau_J;
  const model::ArmModel& arm = model::ArmModel::Panda();
  const model::JointMatrix M = arm.MassMatrix(drive.q_d, kHand);
  const JointVector c = arm.Coriolis(drive.q_d, drive.dq_d, kHand);
  const JointVector g = arm.Gravity(drive.q_d, kHand);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(tau_J[i], 3 * M[i] + c[i] + g[i], 1e-10);
  drive.tau = {};
  plant.Step(drive);
  EXPECT_EQ(plant.sensors().tau_J, tau_J);
}

TEST(IdealPlantTest, BrakesHoldItWhereItIs) {
  IdealPlant plant;
  plant.Step({.q_d = {0.1, 0.2}, .dq_d = {1}});
  plant.Step({.q_d = {0.3, 0.4}, .dq_d = {1}, .brakes = true});
  EXPECT_EQ(plant.sensors().q, (JointVector{0.1, 0.2}));
  EXPECT_EQ(plant.sensors().dq, JointVector{});
}

}  // namespace
}  // namespace twin::plant::plant_ideal_plant_test
