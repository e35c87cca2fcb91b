#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/joint_parameters.h"
#include "plant/plant_fixture.h"
#include "support/bits.h"

namespace twin::plant::plant_motion_test {
namespace {

using DataCopy = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

DataCopy Copy(const MujocoPlant& plant) {
  return {mj_copyData(nullptr, &plant.model(), &plant.data()), &mj_deleteData};
}

double KineticEnergy(const MujocoPlant& plant) {
  const auto data = Copy(plant);
  JointVector momentum{};
  mj_mulM(&plant.model(), data.get(), momentum.data(), data->qvel);
  return 0.5 * mju_dot(momentum.data(), data->qvel, kJoints);
}

double PotentialEnergy(const MujocoPlant& plant) {
  double energy = 0;
  for (int body = 0; body < plant.model().nbody; ++body) {
    energy += 9.81 * plant.model().body_mass[body] * plant.data().xipos[3 * body + 2];
  }
  return energy;
}

double Energy(const MujocoPlant& plant) {
  return KineticEnergy(plant) + PotentialEnergy(plant);
}

JointVector Plus(JointVector a, const JointVector& b) {
  for (std::size_t i = 0; i < kJoints; ++i) a[i] += b[i];
  return a;
}

double Largest(const JointVector& v) {
  double largest = 0;
  for (const double x : v) largest = std::max(largest, std::abs(x));
  return largest;
}

TEST(PlantMotionTest, TwoInstancesStepToTheSameBytes) {
  const auto a = MujocoPlant::Create(DefaultOptions());
  const auto b = MujocoPlant::Create(DefaultOptions());
  for (MujocoPlant* plant : {a.get(), b.get()}) plant->Reset(kReady);
  JointDrive drive;
  for (int k = 0; k < 2000; ++k) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      drive.tau[i] = a->sensors().tau_J[i] - 2 * a->sensors().dq[i] + 0.3 * std::sin(0.01 * k + i);
    }
    a->Step(drive);
    b->Step(drive);
    ASSERT_EQ(test::Bits(a->sensors()), test::Bits(b->sensors())) << k;
  }
  EXPECT_GT(Largest(a->sensors().dq), 1e-3);
  EXPECT_EQ(a->warning_count(), 0u) << a->DescribeWarnings();
}

TEST(PlantMotionTest, ResetStartsAnewToTheSameBytes) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  const auto run = [&plant] {
    plant->Reset(kReady);
    for (int k = 0; k < 300; ++k) plant->Step({.tau = {1, -2, 0.5, 20, 0.1, 1, 0.2}});
    return plant->sensors();
  };
  const JointSensors first = run();
  const JointSensors second = run();
  EXPECT_EQ(test::Bits(first), test::Bits(second));
}

TEST(PlantMotionTest, RestsUnderItsGravityTorque) {
  const auto plant = MujocoPlant::Create(BareOptions());
  plant->Reset(kReady);
  const JointDrive drive{.tau = plant->GravityTorque(kReady)};
  for (int k = 0; k < 1000; ++k) plant->Step(drive);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(plant->sensors().q[i], kReady[i], 1e-9);
  EXPECT_LT(Largest(plant->sensors().dq), 1e-9);
}

TEST(PlantMotionTest, TorqueSensorsShowGravityAtRest) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset(kReady);
  const JointVector g = plant->GravityTorque(kReady);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(plant->sensors().tau_J[i], g[i], 1e-12);
  plant->Step({.tau = g});
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(plant->sensors().tau_J[i], g[i], 1e-9);
}

// Gravity pulls against the torque that would hold: g . dq < 0, and the hand sinks.
TEST(PlantMotionTest, FallsDownwards) {
  const auto plant = MujocoPlant::Create(BareOptions());
  plant->Reset(kReady);
  const int flange = mj_name2id(&plant->model(), mjOBJ_BODY, "panda_link8");
  const double z = plant->data().xpos[3 * flange + 2];
  const JointVector g = plant->GravityTorque(kReady);
  for (int k = 0; k < 100; ++k) plant->Step({});
  double power = 0;
  for (std::size_t i = 0; i < kJoints; ++i) power += g[i] * plant->sensors().dq[i];
  EXPECT_LT(power, -1);
  EXPECT_LT(plant->data().xpos[3 * flange + 2], z - 0.01);
}

TEST(PlantMotionTest, FrictionlessSwingKeepsItsEnergy) {
  const auto plant = MujocoPlant::Create(BareOptions());
  plant->Reset({0.3, 0.2, -0.4, -1.6, 0.5, 1.8, 0.1});
  const double before = Energy(*plant);
  for (int k = 0; k < 250; ++k) {
    plant->Step({});
    ASSERT_EQ(plant->data().nefc, 0) << "touched something or a joint limit at step " << k;
  }
  EXPECT_GT(KineticEnergy(*plant), 5);
  EXPECT_NEAR(Energy(*plant), before, 0.005 * KineticEnergy(*plant));
}

// Against the same swing without friction, so that the integrator's own drift cancels.
TEST(PlantMotionTest, ResidualFrictionTakesEnergyAway) {
  MujocoPlantOptions options = BareOptions();
  const auto free = MujocoPlant::Create(options);
  options.friction = FrictionProfile::kResidual;
  const auto plant = MujocoPlant::Create(options);
  const JointVector q{0.3, 0.2, -0.4, -1.6, 0.5, 1.8, 0.1};
  free->Reset(q);
  plant->Reset(q);
  double dissipated = 0;
  for (int k = 0; k < 250; ++k) {
    const JointVector dq = plant->sensors().dq;
    const JointVector tau = ResidualFriction(dq);
    free->Step({});
    plant->Step({});
    for (std::size_t i = 0; i < kJoints; ++i) {
      dissipated += 1e-3 * tau[i] * 0.5 * (dq[i] + plant->sensors().dq[i]);
    }
  }
  EXPECT_GT(dissipated, 0.1);
  EXPECT_NEAR(Energy(*free) - Energy(*plant), dissipated, 0.05 * dissipated);
}

// From rest, one semi-implicit step gives dq = dt ddq with (M + armature) ddq = tau - g.
TEST(PlantMotionTest, ArmatureAddsToTheMassMatrix) {
  MujocoPlantOptions options = BareOptions();
  const auto bare = MujocoPlant::Create(options);
  bare->Reset(kReady);
  mjtNum M[kJoints * kJoints];
  mj_fullM(&bare->model(), M, bare->data().qM);
  options.armature = true;
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  const JointVector push{1, 2, -1, 0.5, 0.2, -0.3, 0.1};
  const JointVector g = plant->GravityTorque(kReady);
  plant->Step({.tau = Plus(g, push)});
  for (std::size_t i = 0; i < kJoints; ++i) {
    double inertial = kArmature[i] * plant->sensors().dq[i] / 1e-3;
    EXPECT_NEAR(plant->sensors().tau_J[i], g[i] + push[i] - inertial, 1e-9);
    for (std::size_t j = 0; j < kJoints; ++j) {
      inertial += M[kJoints * i + j] * plant->sensors().dq[j] / 1e-3;
    }
    EXPECT_NEAR(inertial, push[i], 1e-9) << i;
  }
}

/// How far the joint goes in 200 ms when `share` of its break-away torque is added to gravity's.
double MovedBy(MujocoPlant& plant, std::size_t joint, double share) {
  plant.Reset(kReady);
  JointDrive drive{.tau = plant.GravityTorque(kReady)};
  drive.tau[joint] += share * kBreakawayTorque[joint];
  for (int k = 0; k < 200; ++k) plant.Step(drive);
  return plant.sensors().q[joint] - kReady[joint];
}

TEST(PlantMotionTest, BreakawayProfileHoldsUpToItsTorque) {
  MujocoPlantOptions options = BareOptions();
  options.armature = true;
  options.friction = FrictionProfile::kBreakaway;
  const auto plant = MujocoPlant::Create(options);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_LT(std::abs(MovedBy(*plant, i, 0.9)), 1e-4) << "joint " << i + 1;
    EXPECT_GT(MovedBy(*plant, i, 1.5), 2e-3) << "joint " << i + 1;
    EXPECT_LT(MovedBy(*plant, i, -1.5), -2e-3) << "joint " << i + 1;
  }
}

TEST(PlantMotionTest, DataShowsThePoseOfTheSensors) {
  const auto plant = MujocoPlant::Create(BareOptions());
  plant->Reset(kReady);
  for (int k = 0; k < 100; ++k) plant->Step({});
  auto data = Copy(*plant);
  mj_kinematics(&plant->model(), data.get());
  for (int i = 0; i < 3 * plant->model().nbody; ++i) {
    EXPECT_EQ(plant->data().xpos[i], data->xpos[i]);
  }
  std::array<double, kJoints> qpos{};
  ASSERT_EQ(plant->qpos_size(), kJoints);
  plant->CopyQpos(qpos);
  EXPECT_EQ(qpos, plant->sensors().q);
  EXPECT_EQ(plant->sensors().theta, plant->sensors().q);
  EXPECT_EQ(plant->sensors().dtheta, plant->sensors().dq);
}

TEST(PlantMotionTest, ArmStopsAtTheFloor) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset({0, 0.6, 0, -1.9, 0, 2.5, 0.785});
  ASSERT_EQ(plant->data().ncon, 0);
  bool touched = false;
  double lowest = 1;
  const int finger = mj_name2id(&plant->model(), mjOBJ_BODY, "panda_leftfinger");
  for (int k = 0; k < 1500; ++k) {
    plant->Step({});
    touched = touched || plant->data().ncon > 0;
    lowest = std::min(lowest, plant->data().xpos[3 * finger + 2]);
  }
  EXPECT_TRUE(touched);
  EXPECT_GT(lowest, 0.04);  // the fingers reach 0.0545 below their frames
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
}

TEST(PlantMotionTest, InstabilityHaltsTheArmAndIsCounted) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset(kReady);
  JointDrive drive{.tau = plant->GravityTorque(kReady)};
  plant->Step(drive);
  drive.tau[3] = std::numeric_limits<double>::quiet_NaN();
  plant->Step(drive);
  EXPECT_GE(plant->warning_count(), 1u);
  EXPECT_FALSE(plant->DescribeWarnings().empty());
  for (const double q : plant->sensors().q) EXPECT_TRUE(std::isnan(q)) << "nothing is measured";
  const std::uint64_t count = plant->warning_count();
  plant->Step({.tau = plant->GravityTorque(kReady)});
  EXPECT_EQ(plant->warning_count(), count + 1);
  plant->Reset(kReady);
  plant->Step({.tau = plant->GravityTorque(kReady)});
  EXPECT_EQ(plant->warning_count(), count + 1);
  EXPECT_NEAR(plant->sensors().q[1], kReady[1], 1e-3);
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

}  // namespace
}  // namespace twin::plant::plant_motion_test
