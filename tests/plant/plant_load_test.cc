#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/joint_parameters.h"
#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"

namespace twin::plant::plant_load_test {
namespace {

using ::testing::HasSubstr;

constexpr setting::Load kLoad{.m_load = 1.5,
                              .F_x_Cload = {0.02, -0.03, 0.12},
                              .I_load = {0.01, 0.001, 0, 0.001, 0.012, -0.002, 0, -0.002, 0.008}};

JointVector SomePose(std::uint64_t k) {
  const Random random(5, RandomStream::kTest);
  JointVector q = kReady;
  for (std::uint32_t i = 0; i < kJoints; ++i) q[i] += 1.2 * (random.Uniform(k, i) - 0.5);
  return q;
}

// Against our own model of the arm, which is no part of the engine's.
TEST(PlantLoadTest, WeighsWhatItShould) {
  MujocoPlantOptions options = BareOptions();
  const auto free = MujocoPlant::Create(options);
  options.load = kLoad;
  const auto loaded = MujocoPlant::Create(options);
  const model::Payload payload{kLoad.m_load, kLoad.F_x_Cload, kLoad.I_load};
  const model::ArmModel& arm = model::ArmModel::Panda();
  for (std::uint64_t k = 0; k < 20; ++k) {
    const JointVector q = SomePose(k);
    const JointVector with = arm.Gravity(q, payload);
    const JointVector without = arm.Gravity(q, {});
    const JointVector g = free->GravityTorque(q);
    const JointVector g_loaded = loaded->GravityTorque(q);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(g_loaded[i] - g[i], with[i] - without[i], 1e-9) << i;
    }
  }
}

TEST(PlantLoadTest, IsAsInertAsItShouldBe) {
  MujocoPlantOptions options = BareOptions();
  const auto mass_matrix = [&options] {
    const auto plant = MujocoPlant::Create(options);
    plant->Reset(SomePose(3));
    std::array<mjtNum, kJoints * kJoints> M{};
    mj_fullM(&plant->model(), M.data(), plant->data().qM);
    return M;
  };
  const auto free = mass_matrix();
  options.load = kLoad;
  const auto loaded = mass_matrix();
  const model::Payload payload{kLoad.m_load, kLoad.F_x_Cload, kLoad.I_load};
  const auto with = model::ArmModel::Panda().MassMatrix(SomePose(3), payload);
  const auto without = model::ArmModel::Panda().MassMatrix(SomePose(3), {});
  for (std::size_t i = 0; i < kJoints * kJoints; ++i) {
    EXPECT_NEAR(loaded[i] - free[i], with[i] - without[i], 1e-8) << i;
  }
}

TEST(PlantLoadTest, WithoutInertiaIsABallOfSteel) {
  MujocoPlantOptions options = BareOptions();
  options.load = {.m_load = 1, .F_x_Cload = {0, 0, 0.05}};
  const auto plant = MujocoPlant::Create(options);
  const int body = mj_name2id(&plant->model(), mjOBJ_BODY, "load");
  ASSERT_GT(body, 0);
  const double r = std::cbrt(3 / (4 * M_PI * 7850));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(plant->model().body_inertia[3 * body + i], 0.4 * r * r, 1e-9);
  }
}

TEST(PlantLoadTest, IsRefusedWhenItCannotBe) {
  MujocoPlantOptions options = BareOptions();
  options.load.m_load = -1;
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("the load on the flange: load_mass is -1"));
  options.load = {.m_load = 1, .F_x_Cload = {0, std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("F_x_Cload"));
  options.load = {.m_load = 1, .F_x_Cload = {}, .I_load = {1, 0, 0, 0, 0.1, 0, 0, 0, 0.2}};
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("the load on the flange: load_inertia must be that of a body"));
  options.load.I_load = {0.1, 0, 0, 0, 0, 0, 0, 0, 0.1};
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              HasSubstr("a rod without thickness"));
}

TEST(PlantElasticityTest, BendsTheMotorsAheadOfTheLinks) {
  MujocoPlantOptions options = DefaultOptions();
  options.elasticity = ElasticityProfile::kStatic;
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  JointVector before = plant->sensors().theta;
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_DOUBLE_EQ(before[i], kReady[i] + plant->GravityTorque(kReady)[i] / kJointStiffness[i]);
  }
  EXPECT_EQ(plant->sensors().dtheta, JointVector{}) << "at rest";
  for (int k = 0; k < 300; ++k) {
    plant->Step({.tau = {1, -2, 0.5, 20 + 5 * std::sin(0.05 * k)}});
    const JointSensors& now = plant->sensors();
    for (std::size_t i = 0; i < kJoints; ++i) {
      ASSERT_DOUBLE_EQ(now.theta[i], now.q[i] + now.tau_J[i] / kJointStiffness[i]);
      // The engine's q moves by dq of the end of the step: so dtheta is theta's own difference.
      ASSERT_NEAR(now.dtheta[i], (now.theta[i] - before[i]) / 1e-3, 1e-9) << i << " " << k;
    }
    before = now.theta;
  }
}

TEST(PlantElasticityTest, ChangesNothingOfTheMotion) {
  MujocoPlantOptions options = DefaultOptions();
  const auto rigid = MujocoPlant::Create(options);
  options.elasticity = ElasticityProfile::kStatic;
  const auto elastic = MujocoPlant::Create(options);
  for (MujocoPlant* plant : {rigid.get(), elastic.get()}) plant->Reset(kReady);
  for (int k = 0; k < 300; ++k) {
    for (MujocoPlant* plant : {rigid.get(), elastic.get()}) plant->Step({.tau = {1, -2, 0.5, 20}});
    ASSERT_EQ(rigid->sensors().q, elastic->sensors().q);
    ASSERT_EQ(rigid->sensors().tau_J, elastic->sensors().tau_J);
    ASSERT_EQ(rigid->sensors().theta, rigid->sensors().q);
  }
}

}  // namespace
}  // namespace twin::plant::plant_load_test
