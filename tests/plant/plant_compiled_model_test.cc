#include "twin/plant/compiled_model.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"

namespace twin::plant {
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

TEST(CompiledModelTest, NamesAMissingScene) {
  MujocoPlantOptions options = DefaultOptions();
  options.scene = "nowhere.xml";
  EXPECT_THAT(MessageOf<InputError>([&] { static_cast<void>(CompileModel(options)); }),
              testing::HasSubstr("nowhere.xml"));
}

}  // namespace
}  // namespace twin::plant
