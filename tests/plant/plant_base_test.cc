#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/husky.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/plant/contact_watch.h"

namespace twin::plant::plant_base_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kWheelRadius = 0.1651;

MujocoPlantOptions OnHusky(const BasePose& start = {}) {
  MujocoPlantOptions options = DefaultOptions();
  options.base = test::Husky(start);
  return options;
}

int Body(const MujocoPlant& plant, const char* name) {
  return mj_name2id(&plant.model(), mjOBJ_BODY, name);
}

std::array<double, 3> Place(const MujocoPlant& plant, const char* body) {
  const double* p = plant.data().xpos + 3 * Body(plant, body);
  return {p[0], p[1], p[2]};
}

/// A stiff arm at the ready pose, on wheels that are braked and driven with `tau`.
void Hold(MujocoPlant& plant, int cycles, double tau = 0, double brake = 20) {
  JointDrive drive;
  const JointVector g = plant.GravityTorque(kReady);
  for (int k = 0; k < cycles; ++k) {
    WheelDrive wheels;
    for (std::size_t i = 0; i < 4; ++i) {
      wheels.tau[i] = tau - brake * plant.base()->sensors().dq[i];
    }
    plant.base()->Drive(wheels);
    for (std::size_t i = 0; i < kJoints; ++i) {
      const JointSensors& s = plant.sensors();
      drive.tau[i] = g[i] + 3000 * (kReady[i] - s.q[i]) - 60 * s.dq[i];
    }
    plant.Step(drive);
  }
}

TEST(PlantBaseTest, ThereIsNoneUnlessAskedFor) {
  EXPECT_EQ(MujocoPlant::Create(DefaultOptions())->base(), nullptr);
}

TEST(PlantBaseTest, StandsWhereItIsPut) {
  const auto plant = MujocoPlant::Create(OnHusky({1.5, -0.5, 0.7}));
  const auto base = Place(*plant, "husky_base_link");
  EXPECT_EQ(base[0], 1.5);
  EXPECT_EQ(base[1], -0.5);
  EXPECT_NEAR(base[2], kWheelRadius - 0.03282, 2e-3) << "on tyres that give way";
  const double* R = plant->data().xmat + 9 * Body(*plant, "husky_base_link");
  EXPECT_NEAR(std::atan2(R[3], R[0]), 0.7, 1e-5);
  EXPECT_NEAR(R[8], 1, 1e-6) << "level";
}

TEST(PlantBaseTest, CarriesTheArmOnItsTopPlate) {
  const auto plant = MujocoPlant::Create(OnHusky({1.5, -0.5, 0.7}));
  const auto O = Place(*plant, "panda_link0");
  EXPECT_NEAR(O[0], 1.5 + 0.22 * std::cos(0.7), 1e-4);
  EXPECT_NEAR(O[1], -0.5 + 0.22 * std::sin(0.7), 1e-4);
  EXPECT_NEAR(O[2], 0.2601 + kWheelRadius - 0.03282, 2e-3);
}

TEST(PlantBaseTest, ItsWheelsBearAllOfIt) {
  const auto plant = MujocoPlant::Create(OnHusky());
  Hold(*plant, 500);
  double force = 0;
  for (int i = 0; i < plant->data().ncon; ++i) {
    // Of the step before; nothing moves.
    force += plant->data().efc_force[plant->data().contact[i].efc_address];
  }
  EXPECT_NEAR(force, mj_getTotalmass(&plant->model()) * 9.81, 0.5);
}

TEST(PlantBaseTest, RestsWithoutDriftOrShaking) {
  const auto plant = MujocoPlant::Create(OnHusky());
  const auto before = Place(*plant, "panda_hand");
  double fastest = 0;
  for (int k = 0; k < 100; ++k) {
    Hold(*plant, 100);
    for (int i = 0; i < 6; ++i) fastest = std::max(fastest, std::abs(plant->data().qvel[i]));
  }
  const auto after = Place(*plant, "panda_hand");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(after[i], before[i], 1e-4) << "10 s later";
  EXPECT_LT(fastest, 1e-5);
}

TEST(PlantBaseTest, TheArmWeighsOnItWhatItWeighsOnTheWorld) {
  MujocoPlantOptions options = DefaultOptions();
  const JointVector on_world = MujocoPlant::Create(options)->GravityTorque(kReady);
  const JointVector on_base = MujocoPlant::Create(OnHusky({0, 0, 1}))->GravityTorque(kReady);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(on_base[i], on_world[i], 1e-10);
}

TEST(PlantBaseTest, AcceleratesByTheTorqueOnItsWheels) {
  // a = 4 tau / R / (m + 4 I / R^2), I of a wheel and its rotor.
  const auto plant = MujocoPlant::Create(OnHusky());
  const double inertia = 0.04411 + 0.3;
  const double felt = mj_getTotalmass(&plant->model()) + 4 * inertia / kWheelRadius / kWheelRadius;
  Hold(*plant, 1000, 3, 0);
  const double a = 4 * 3 / kWheelRadius / felt;
  EXPECT_NEAR(plant->data().qvel[0], a * 1, 0.02 * a);
}

TEST(PlantBaseTest, TurningWheelsReadAsTheyTurn) {
  const auto plant = MujocoPlant::Create(OnHusky());
  Hold(*plant, 1500, 3, 0);
  const double way = Place(*plant, "husky_base_link")[0];
  for (const double q : plant->base()->sensors().q) EXPECT_NEAR(q * kWheelRadius, way, 0.01 * way);
}

TEST(PlantBaseTest, BeginsTheSameAfterEveryReset) {
  const auto plant = MujocoPlant::Create(OnHusky());
  const auto run = [&plant] {
    plant->Reset(kReady);
    Hold(*plant, 200, 5, 0);
    std::vector<double> qpos(plant->qpos_size());
    plant->CopyQpos(qpos);
    return qpos;
  };
  const auto first = run();
  EXPECT_EQ(run(), first);
}

TEST(PlantBaseTest, StepsWithoutAllocationOrLock) {
  const auto plant = MujocoPlant::Create(OnHusky());
  plant->base()->Drive({{6, -6, 6, -6}});  // it turns on the spot, and slides
  const JointDrive drive{.tau = plant->GravityTorque(kReady)};
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1500; ++k) plant->Step(drive);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
}

TEST(PlantBaseTest, ItsBodyTouchesButItsWheelsDoNotCount) {
  MujocoPlantOptions options = OnHusky();
  options.objects = {{.name = "wall", .size = {0.1, 1, 0.3}, .X_WB = kIdentityTransform}};
  options.objects[0].X_WB[12] = 0.542;  // 1 to 2 mm into the bumper
  options.objects[0].X_WB[14] = 0.15;
  const auto plant = MujocoPlant::Create(options);
  ContactWatch watch(*plant);
  for (int k = 0; k < 20; ++k) {
    Hold(*plant, 1);
    watch.Look(Time(k * kCycle));
  }
  const auto pairs = watch.Pairs();
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].a, "husky_base_link");
  EXPECT_EQ(pairs[0].b, "wall");
}

TEST(PlantBaseTest, RefusesToStandInsideOfSomething) {
  MujocoPlantOptions options = OnHusky({2, 0, 0});
  options.objects = {{.name = "block", .size = {0.3, 0.3, 0.3}, .X_WB = kIdentityTransform}};
  options.objects[0].X_WB[12] = 2;
  options.objects[0].X_WB[14] = 0.15;
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              AllOf(HasSubstr("cannot stand at x = 2 m, y = 0 m"), HasSubstr("block")));
}

TEST(PlantBaseTest, IsNoObjectToWatch) {
  const auto plant = MujocoPlant::Create(OnHusky());
  EXPECT_TRUE(ObjectWatch(*plant).Tracks().empty());
}

/// The message for the Husky's URDF with `from` replaced by `to`.
std::string RefusalOf(const std::string& from, const std::string& to) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = OnHusky();
  std::string urdf = ReadText(options.base->urdf);
  EXPECT_NE(urdf.find(from), std::string::npos) << from;
  for (std::size_t at = urdf.find(from); at != std::string::npos;
       at = urdf.find(from, at + to.size())) {
    urdf.replace(at, from.size(), to);
  }
  options.base->urdf = folder.Write("husky.urdf", urdf);
  return MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); });
}

TEST(PlantBaseTest, RefusesABaseWithoutAPlaceForTheArm) {
  EXPECT_THAT(RefusalOf("\"arm_mount\"", "\"top\""),
              AllOf(HasSubstr("husky.urdf"), HasSubstr("arm_mount")));
}

TEST(PlantBaseTest, RefusesABaseWithoutFourWheels) {
  EXPECT_THAT(RefusalOf("rear_left_wheel\"", "spare\""), HasSubstr("needs a wheel 'rear_left"));
}

TEST(PlantBaseTest, RefusesWheelsAboutAnotherAxis) {
  EXPECT_THAT(RefusalOf("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"1 0 0\"/>"), HasSubstr("about y"));
}

TEST(PlantBaseTest, RefusesMeshes) {
  EXPECT_THAT(RefusalOf("<box size=\"0.84 0.44 0.19\"/>", "<mesh filename=\"a.stl\"/>"),
              HasSubstr("link 'husky_base_link' has a mesh"));
}

TEST(PlantBaseTest, RefusesNamesOfTheArm) {
  EXPECT_THAT(RefusalOf("\"panda_power\"", "\"panda_link3\""), HasSubstr("'panda_link3' is also"));
}

TEST(PlantBaseTest, RefusesATiltedBase) {
  MujocoPlantOptions options = OnHusky();
  options.base_tilt.roll = 0.1;
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("mobile base"));
}

TEST(PlantBaseTest, RefusesWheelsOnTheArm) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  std::string urdf = ReadText(options.urdf);
  urdf.replace(urdf.find("\"revolute\""), 10, "\"continuous\"");
  folder.Write("primitives.yaml", ReadText(options.urdf.parent_path() / "primitives.yaml"));
  options.urdf = folder.Write("panda.urdf", urdf);
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("is continuous"));
}

}  // namespace
}  // namespace twin::plant::plant_base_test
