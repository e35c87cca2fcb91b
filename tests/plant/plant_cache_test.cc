#include <cstring>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

std::vector<std::filesystem::path> Entries(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> entries;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) entries.push_back(entry);
  return entries;
}

/// All bytes of the state after `steps` steps under a torque that depends on the step.
std::string StateAfter(MujocoPlant& plant, int steps) {
  plant.Reset(kReady);
  JointDrive drive;
  drive.tau = plant.GravityTorque(kReady);
  for (int k = 0; k < steps; ++k) {
    drive.tau[static_cast<std::size_t>(k) % kJoints] += 0.01 * ((k % 5) - 2);
    plant.Step(drive);
  }
  const mjData& data = plant.data();
  std::string bytes(reinterpret_cast<const char*>(&plant.sensors()), sizeof(JointSensors));
  bytes.append(reinterpret_cast<const char*>(data.qpos), sizeof(double) * plant.qpos_size());
  bytes.append(reinterpret_cast<const char*>(data.qacc_warmstart),
               sizeof(double) * static_cast<std::size_t>(plant.model().nv));
  return bytes;
}

TEST(ModelCacheTest, FreshAndCachedModelsStepToTheSameBytes) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = DefaultOptions();
  options.cache = folder.path();
  const std::string fresh = StateAfter(*MujocoPlant::Create(options), 2000);
  ASSERT_EQ(Entries(folder.path()).size(), 1u);
  EXPECT_EQ(StateAfter(*MujocoPlant::Create(options), 2000), fresh);
  EXPECT_EQ(Entries(folder.path()).size(), 1u);
}

TEST(ModelCacheTest, EveryInputHasItsOwnEntry) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  options.cache = folder.path() / "made" / "when needed";
  (void)MujocoPlant::Create(options);
  options.armature = true;
  (void)MujocoPlant::Create(options);
  options.friction = FrictionProfile::kBreakaway;
  (void)MujocoPlant::Create(options);
  options.hand = HandKind::kFrankaHand;
  (void)MujocoPlant::Create(options);
  options.scene = folder.Write("scene.xml", "<mujoco><option wind='1 0 0'/></mujoco>");
  (void)MujocoPlant::Create(options);
  folder.Write("scene.xml", "<mujoco><option wind='0 0 0'/></mujoco>");
  (void)MujocoPlant::Create(options);
  EXPECT_EQ(Entries(options.cache).size(), 6u);
}

// What lies in such files is not covered by the key.
TEST(ModelCacheTest, ScenesThatNameFilesAreNotCached) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  options.cache = folder.path() / "cache";
  folder.Write("ball.xml", "<mujoco><worldbody><geom name='ball' size='.1'/></worldbody></mujoco>");
  options.scene = folder.Write("scene.xml", "<mujoco><include file = 'ball.xml'/></mujoco>");
  const auto plant = MujocoPlant::Create(options);
  EXPECT_GE(mj_name2id(&plant->model(), mjOBJ_GEOM, "ball"), 0);
  EXPECT_FALSE(std::filesystem::exists(options.cache));
}

class CorruptCacheTest : public testing::Test {
 protected:
  CorruptCacheTest() {
    options_.cache = folder_.path();
    (void)MujocoPlant::Create(options_);
    entry_ = Entries(folder_.path()).at(0);
    bytes_ = ReadText(entry_);
  }

  void ExpectRefused(const std::string& bytes) const {
    folder_.Write(entry_.filename(), bytes);
    const std::string message =
        MessageOf<EnvironmentError>([this] { (void)MujocoPlant::Create(options_); });
    EXPECT_THAT(message, testing::HasSubstr(entry_.string()));
    EXPECT_THAT(message, testing::HasSubstr("--rebuild-cache"));
  }

  TemporaryFolder folder_;
  MujocoPlantOptions options_ = BareOptions();
  std::filesystem::path entry_;
  std::string bytes_;
};

TEST_F(CorruptCacheTest, AnyDamageIsNamedWithItsCure) {
  ExpectRefused("");
  ExpectRefused(bytes_.substr(0, 20));
  ExpectRefused(bytes_.substr(0, bytes_.size() - 1));
  ExpectRefused(bytes_ + "x");
  for (const std::size_t place : {std::size_t{3}, bytes_.size() / 2, bytes_.size() - 1}) {
    std::string damaged = bytes_;
    damaged[place] ^= 0x10;
    ExpectRefused(damaged);
  }
}

TEST_F(CorruptCacheTest, RebuildReplacesIt) {
  folder_.Write(entry_.filename(), "rubbish");
  options_.rebuild_cache = true;
  EXPECT_NO_THROW((void)MujocoPlant::Create(options_));
  EXPECT_EQ(ReadText(entry_), bytes_);
}

}  // namespace
}  // namespace twin::plant
