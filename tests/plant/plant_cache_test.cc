#include <chrono>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/plant/model_cache.h"

namespace twin::plant::plant_cache_test {
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

  /// With damaged bytes the model is compiled anew, the same; who repairs the cache is told.
  void ExpectReplaced(const std::string& bytes) {
    folder_.Write(entry_.filename(), bytes);
    EXPECT_NO_THROW((void)MujocoPlant::Create(options_));
    EXPECT_EQ(ReadText(entry_), bytes_);
    folder_.Write(entry_.filename(), bytes);
    notes_.clear();
    EXPECT_TRUE(Repair(folder_.path()));
    ASSERT_EQ(notes_.size(), 1u);
    EXPECT_THAT(notes_[0], testing::HasSubstr(entry_.string()));
    EXPECT_THAT(notes_[0], testing::HasSubstr("damaged"));
    EXPECT_THAT(notes_[0], testing::Not(testing::HasSubstr("--")));
    EXPECT_FALSE(std::filesystem::exists(entry_));
  }
  [[nodiscard]] bool Repair(const std::filesystem::path& folder) {
    return RepairModelCache(folder, [this](std::string_view text) { notes_.emplace_back(text); });
  }

  TemporaryFolder folder_;
  MujocoPlantOptions options_ = BareOptions();
  std::filesystem::path entry_;
  std::string bytes_;
  std::vector<std::string> notes_;
};

TEST_F(CorruptCacheTest, AnyDamageIsMendedAndNoted) {
  ExpectReplaced("");
  ExpectReplaced(bytes_.substr(0, 20));
  ExpectReplaced(bytes_.substr(0, bytes_.size() - 1));
  ExpectReplaced(bytes_ + "x");
  for (const std::size_t place : {std::size_t{3}, bytes_.size() / 2, bytes_.size() - 1}) {
    std::string damaged = bytes_;
    damaged[place] ^= 0x10;
    ExpectReplaced(damaged);
  }
}

TEST_F(CorruptCacheTest, AWholeOneStays) {
  EXPECT_TRUE(Repair(folder_.path()));
  EXPECT_TRUE(notes_.empty());
  EXPECT_EQ(ReadText(entry_), bytes_);
}

TEST_F(CorruptCacheTest, ACacheThatCannotBeWrittenIsNotedAndDoneWithout) {
  options_.cache = entry_ / "below a file";
  EXPECT_NO_THROW((void)MujocoPlant::Create(options_));
  EXPECT_FALSE(Repair(options_.cache));
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_THAT(notes_[0], testing::HasSubstr(options_.cache.string()));
  EXPECT_THAT(notes_[0], testing::HasSubstr("cannot be kept"));
}

TEST(ModelCacheTest, KeepsThoseUsedLast) {
  const TemporaryFolder folder;
  const ModelCache cache(folder.path());
  const auto base = std::filesystem::last_write_time(folder.path()) - std::chrono::hours(24);
  const auto age = [&](const std::string& name, std::size_t seconds) {
    std::filesystem::last_write_time(folder.path() / name, base + std::chrono::seconds(seconds));
  };
  folder.Write("mine.txt", "mine");
  folder.Write("old.mjb.77.partial", "left by a killed process");
  age("old.mjb.77.partial", 0);
  for (std::size_t i = 0; i < kMostCachedModels + 3; ++i) {
    cache.Store(std::to_string(i), "a model");
    age(std::to_string(i) + ".mjb", 1 + i);
  }
  EXPECT_EQ(cache.Load("1"), "a model");  // used now
  EXPECT_TRUE(
      RepairModelCache(folder.path(), [](std::string_view text) { ADD_FAILURE() << text; }));
  EXPECT_EQ(Entries(folder.path()).size(), kMostCachedModels + 1);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "mine.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "old.mjb.77.partial"));
  for (const char* gone : {"0", "2", "3"}) EXPECT_FALSE(cache.Load(gone)) << gone;
  for (const char* kept : {"1", "4"}) EXPECT_TRUE(cache.Load(kept)) << kept;
}

TEST_F(CorruptCacheTest, RebuildReplacesIt) {
  folder_.Write(entry_.filename(), "rubbish");
  options_.rebuild_cache = true;
  EXPECT_NO_THROW((void)MujocoPlant::Create(options_));
  EXPECT_EQ(ReadText(entry_), bytes_);
}

}  // namespace
}  // namespace twin::plant::plant_cache_test
