#include <chrono>
#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/bits.h"
#include "support/realtime_guard.h"

namespace twin::plant::plant_brakes_test {
namespace {

constexpr JointVector kAway{0.5, 0.6, -0.4, -1.2, 0.3, 1.9, 0.2};  // gravity pulls at every joint

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

const JointDrive kBraked{.brakes = true};

TEST(BrakesTest, HoldTheArmWithoutItsMotors) {
  for (const auto friction :
       {FrictionProfile::kNone, FrictionProfile::kResidual, FrictionProfile::kBreakaway}) {
    for (const bool armature : {true, false}) {
      MujocoPlantOptions options = DefaultOptions();
      options.friction = friction;
      options.armature = armature;
      options.load = {.m_load = 3, .F_x_Cload = {0, 0, 0.1}};
      const auto plant = MujocoPlant::Create(options);
      plant->Reset(kAway);
      for (int k = 0; k < 20; ++k) plant->Step(kBraked);
      const JointVector q = plant->sensors().q;
      EXPECT_LT(LargestDistance(q, kAway), 2e-4) << "as they close";
      for (int k = 0; k < 10'000; ++k) plant->Step(kBraked);
      EXPECT_LT(LargestDistance(plant->sensors().q, q), 1e-6) << "no creep in 10 s";
    }
  }
}

// Behind the brake, which is on the motor, the gear still carries the arm's weight.
TEST(BrakesTest, TorqueSensorsShowGravityWhateverTheMotorsDo) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset(kAway);
  JointDrive drive{.tau = {30, -40, 20, 10, -5, 5, 5}, .brakes = true};
  for (int k = 0; k < 1000; ++k) plant->Step(drive);
  EXPECT_LT(LargestDistance(plant->sensors().q, kAway), 1e-3);
  const JointVector g = plant->GravityTorque(plant->sensors().q);
  EXPECT_LT(LargestDistance(plant->sensors().tau_J, g), 1e-3);
}

TEST(BrakesTest, StopAMovingArmAndLetItGoAgain) {
  const auto plant = MujocoPlant::Create(BareOptions());
  plant->Reset(kAway);
  for (int k = 0; k < 150; ++k) plant->Step({});
  ASSERT_GT(LargestDistance(plant->sensors().dq, {}), 0.5);
  for (int k = 0; k < 200; ++k) plant->Step(kBraked);
  const JointVector held = plant->sensors().q;
  EXPECT_LT(LargestDistance(plant->sensors().dq, {}), 1e-6);
  for (int k = 0; k < 100; ++k) plant->Step({});
  EXPECT_GT(LargestDistance(plant->sensors().q, held), 1e-2) << "it falls when they open";
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
}

/// How far joint 1 moves under closed brakes in half a second of a torque, rad.
double Slip(MujocoPlant& plant, double tau) {
  plant.Reset(kReady);
  JointDrive drive{.tau = plant.GravityTorque(kReady), .brakes = true};
  drive.tau[0] += tau;
  for (int k = 0; k < 500; ++k) plant.Step(drive);
  return std::abs(plant.sensors().q[0] - kReady[0]);
}

TEST(BrakesTest, SlipBeyondTwiceTheLargestTorque) {
  const auto plant = MujocoPlant::Create(BareOptions());
  EXPECT_LT(Slip(*plant, 0.97 * 174), 2e-3);
  EXPECT_GT(Slip(*plant, 1.03 * 174), 2e-2);
}

TEST(BrakesTest, AWeakerDriveHasAWeakerBrake) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  std::string text = ReadText(options.urdf);
  const std::string effort = "effort=\"87\"";  // the first is joint 1's
  text.replace(text.find(effort), effort.size(), "effort=\"40\"");
  folder.Write("primitives.yaml", ReadText(options.urdf.parent_path() / "primitives.yaml"));
  options.urdf = folder.Write("panda.urdf", text);
  const auto plant = MujocoPlant::Create(options);
  EXPECT_LT(Slip(*plant, 0.97 * 80), 2e-3);
  EXPECT_GT(Slip(*plant, 1.03 * 80), 2e-2);
}

TEST(BrakesTest, OpenBrakesLeaveNoTrace) {
  const auto a = MujocoPlant::Create(DefaultOptions());
  const auto b = MujocoPlant::Create(DefaultOptions());
  a->Reset(kReady);
  for (int k = 0; k < 10; ++k) a->Step(kBraked);
  for (MujocoPlant* plant : {a.get(), b.get()}) plant->Reset(kReady);
  for (int k = 0; k < 300; ++k) {
    for (MujocoPlant* plant : {a.get(), b.get()}) plant->Step({.tau = {1, -2, 0.5, 20}});
    ASSERT_EQ(test::Bits(a->sensors()), test::Bits(b->sensors())) << k;
  }
}

TEST(BrakesTest, CloseAndOpenWithoutAllocationOrLock) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset(kReady);
  const JointVector g = plant->GravityTorque(kReady);
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) plant->Step({.tau = g, .brakes = k / 100 % 2 == 1});
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_EQ(counts.locks, 0);
}

}  // namespace
}  // namespace twin::plant::plant_brakes_test
