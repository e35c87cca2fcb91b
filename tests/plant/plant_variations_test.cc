#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"

namespace twin::plant::plant_variations_test {
namespace {

using MassMatrix = std::array<mjtNum, kJoints * kJoints>;

JointVector SomePose(std::uint64_t k) {
  const Random random(7, RandomStream::kTest);
  JointVector q = kReady;
  for (std::uint32_t i = 0; i < kJoints; ++i) q[i] += 1.2 * (random.Uniform(k, i) - 0.5);
  return q;
}

MassMatrix MassMatrixAt(const JointVector& q, const MujocoPlantOptions& options) {
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(q);
  MassMatrix M{};
  mj_fullM(&plant->model(), M.data(), plant->data().qM);
  return M;
}

TEST(PlantVariationsTest, AScaledArmWeighsAndResistsByTheScale) {
  MujocoPlantOptions options = BareOptions();
  const auto light = MujocoPlant::Create(options);
  const MassMatrix M = MassMatrixAt(SomePose(1), options);
  options.mass_scale = 1.05;
  const auto heavy = MujocoPlant::Create(options);
  const MassMatrix M_heavy = MassMatrixAt(SomePose(1), options);
  const JointVector g = light->GravityTorque(SomePose(1));
  const JointVector g_heavy = heavy->GravityTorque(SomePose(1));
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(g_heavy[i], 1.05 * g[i], 1e-9) << i;
  for (std::size_t i = 0; i < M.size(); ++i) EXPECT_NEAR(M_heavy[i], 1.05 * M[i], 1e-9) << i;
}

TEST(PlantVariationsTest, TheHandIsScaledAndTheLoadIsNot) {
  MujocoPlantOptions options = DefaultOptions();
  options.load.m_load = 1;
  const auto mass = [&options] {
    const auto plant = MujocoPlant::Create(options);
    return mj_getTotalmass(&plant->model());
  };
  const double before = mass();
  options.mass_scale = 2;
  EXPECT_NEAR(mass() - 1, 2 * (before - 1), 1e-9);
}

// Against our own model of the arm, which takes any direction of gravity.
TEST(PlantVariationsTest, ALeaningBaseBearsItsShareOfGravity) {
  MujocoPlantOptions options = BareOptions();
  const auto level = MujocoPlant::Create(options);
  options.base_tilt = {.roll = 0.03, .pitch = -0.05};
  const auto leaning = MujocoPlant::Create(options);
  // "Down" in a base that is first rolled about x, then pitched about the level y.
  const double down_after_pitch_x = -std::sin(0.05) * 9.81;
  const double down_after_pitch_z = -std::cos(0.05) * 9.81;
  const Vector3 g_leaning{down_after_pitch_x, std::sin(0.03) * down_after_pitch_z,
                          std::cos(0.03) * down_after_pitch_z};
  const model::ArmModel& arm = model::ArmModel::Panda();
  for (std::uint64_t k = 0; k < 20; ++k) {
    const JointVector q = SomePose(k);
    const JointVector g = level->GravityTorque(q);
    const JointVector g_tilted = leaning->GravityTorque(q);
    const JointVector expected = arm.Gravity(q, {}, g_leaning);
    const JointVector expected_level = arm.Gravity(q, {});
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(g_tilted[i] - g[i], expected[i] - expected_level[i], 1e-6) << i;
    }
    EXPECT_GT(std::abs(g_tilted[0]), 1e-3) << "level, the first joint bears nothing";
  }
}

}  // namespace
}  // namespace twin::plant::plant_variations_test
