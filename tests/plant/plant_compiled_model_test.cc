#include "twin/plant/compiled_model.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/husky.h"
#include "twin/core/error.h"

namespace twin::plant::plant_compiled_model_test {
namespace {

TEST(CompiledModelTest, IsWhatThePlantSimulates) {
  const CompiledModel compiled = CompileModel(DefaultOptions());
  const auto plant = MujocoPlant::Create(DefaultOptions());
  const mjModel& expected = plant->model();
  ASSERT_EQ(mj_sizeModel(compiled.model.get()), mj_sizeModel(&expected));
  ASSERT_EQ(compiled.model->ngeom, expected.ngeom);
  for (int i = 0; i < 3 * expected.ngeom; ++i) {
    EXPECT_EQ(compiled.model->geom_pos[i], expected.geom_pos[i]);
    EXPECT_EQ(compiled.model->geom_size[i], expected.geom_size[i]);
  }
}

TEST(CompiledModelTest, KnowsTheRobotsJoints) {
  const CompiledModel compiled = CompileModel(DefaultOptions());
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_EQ(mj_id2name(compiled.model.get(), mjOBJ_JOINT, compiled.arm[i]),
              "panda_joint" + std::to_string(i + 1));
  }
  ASSERT_EQ(compiled.fingers.size(), 2);
  EXPECT_STREQ(mj_id2name(compiled.model.get(), mjOBJ_JOINT, compiled.fingers[0]),
               "panda_finger_joint1");
  EXPECT_TRUE(CompileModel(BareOptions()).fingers.empty());
}

/// O in the world, of a plant as it stands.
Transform TrueArmBase(const MujocoPlant& plant) {
  const int body = mj_name2id(&plant.model(), mjOBJ_BODY, "panda_link0");
  const double* R = plant.data().xmat + 9 * body;
  const double* p = plant.data().xpos + 3 * body;
  return {R[0], R[3], R[6], 0, R[1], R[4], R[7], 0, R[2], R[5], R[8], 0, p[0], p[1], p[2], 1};
}

TEST(CompiledModelTest, TheArmsBaseIsTheWorldsWithoutAMobileBase) {
  const CompiledModel compiled = CompileModel(DefaultOptions());
  EXPECT_EQ(ArmBaseIn(compiled, PositionsAt(compiled, kReady)), kIdentityTransform);
}

TEST(CompiledModelTest, FindsTheArmsBaseOnAMobileBase) {
  MujocoPlantOptions options = DefaultOptions();
  options.base = test::Husky({1.2, -0.3, 0.8});
  const auto plant = MujocoPlant::Create(options);
  plant->base()->Drive({{-25, 30, -25, 30}});
  for (int k = 0; k < 700; ++k) plant->Step({});
  std::vector<double> qpos(plant->qpos_size());
  plant->CopyQpos(qpos);
  const Transform found = ArmBaseIn(CompileModel(options), qpos);
  const Transform expected = TrueArmBase(*plant);
  ASSERT_GT(std::abs(expected[1] - std::sin(0.8)), 0.01) << "it has turned";
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(found[i], expected[i], 1e-12);
}

TEST(CompiledModelTest, MovesAMobileBaseByItsOdometry) {
  MujocoPlantOptions options = DefaultOptions();
  options.base = test::Husky({1, 2, 0.5});
  const CompiledModel moved = CompileModel(options);
  std::vector<double> qpos = PositionsAt(moved, kReady);
  MoveBase(moved, {0.3, 0.1, 0.4}, qpos);
  const double x = 1 + 0.3 * std::cos(0.5) - 0.1 * std::sin(0.5);
  const double y = 2 + 0.3 * std::sin(0.5) + 0.1 * std::cos(0.5);
  options.base->start = {x, y, 0.9};
  const CompiledModel there = CompileModel(options);
  const Transform expected = ArmBaseIn(there, PositionsAt(there, kReady));
  const Transform found = ArmBaseIn(moved, qpos);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(found[i], expected[i], 1e-12);
}

TEST(CompiledModelTest, NamesAMissingScene) {
  MujocoPlantOptions options = DefaultOptions();
  options.scene = "nowhere.xml";
  EXPECT_THAT(MessageOf<InputError>([&] { static_cast<void>(CompileModel(options)); }),
              testing::HasSubstr("nowhere.xml"));
}

}  // namespace
}  // namespace twin::plant::plant_compiled_model_test
