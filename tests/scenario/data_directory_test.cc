#include "twin/scenario/data_directory.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::scenario::data_directory_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// An empty folder per test, gone when the test is over.
class DataDirectoryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(::testing::TempDir()) / (std::string("data_directory_") + test->name());
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  void Make(const std::string& folder) const { fs::create_directories(root_ / folder); }

  fs::path root_;
};

TEST_F(DataDirectoryTest, FindsTheSourceTreeFromABuildFolder) {
  Make("models/robots");
  Make(".data/panda_description/meshes");
  const auto data = FindDataDirectory({root_ / "build/release/panda-twin", {}, {}});
  EXPECT_EQ(data.models, root_ / "models");
  EXPECT_EQ(data.mesh_package, root_ / ".data/panda_description");
}

TEST_F(DataDirectoryTest, PrefersWhatWasInstalledBesideTheProgram) {
  Make("share/panda_twin/models/robots");
  Make("share/panda_twin/panda_description/meshes");
  const auto data = FindDataDirectory({root_ / "bin/panda-twin", {}, {}});
  EXPECT_EQ(data.models, root_ / "share/panda_twin/models");
  EXPECT_EQ(data.mesh_package, root_ / "share/panda_twin/panda_description");
}

TEST_F(DataDirectoryTest, TakesWhatTheUserSays) {
  Make("models/robots");
  Make("mine/robots");
  Make("my_meshes/meshes");
  const auto data =
      FindDataDirectory({root_ / "build/release/panda-twin", root_ / "mine", root_ / "my_meshes"});
  EXPECT_EQ(data.models, root_ / "mine");
  EXPECT_EQ(data.mesh_package, root_ / "my_meshes");
}

TEST_F(DataDirectoryTest, FindsAScenarioBelowTheModelsWhereverItIsNamed) {
  const fs::path models = root_ / "share/models";
  const fs::path file = models / "scenarios/grasp.yaml";
  Make("share/models/scenarios");
  std::ofstream(file) << "name: grasp\n";
  EXPECT_EQ(FindScenario("models/scenarios/grasp.yaml", models), file);
  EXPECT_EQ(FindScenario("scenarios/grasp.yaml", models), file);
  EXPECT_EQ(FindScenario(file, "elsewhere"), file);
  EXPECT_EQ(FindScenario("scenarios/nowhere.yaml", models), "scenarios/nowhere.yaml");
  EXPECT_THAT([&] { (void)FindScenario("grasp.yaml", models); },
              ThrowsMessage<InputError>(HasSubstr("with its folder: scenarios/grasp.yaml")));
}

TEST_F(DataDirectoryTest, DoesWithoutMeshes) {
  Make("models/robots");
  const auto data = FindDataDirectory({root_ / "build/release/panda-twin", {}, {}});
  EXPECT_TRUE(data.mesh_package.empty());
  EXPECT_EQ(data.mesh_candidates.size(), 2u);
}

TEST_F(DataDirectoryTest, SaysWhereItLooked) {
  EXPECT_THAT(
      [&] {
        (void)FindDataDirectory({root_ / "bin/panda-twin", {}, {}});
      },
      ThrowsMessage<EnvironmentError>(::testing::AllOf(
          HasSubstr((root_ / "share/panda_twin/models").string()), HasSubstr("--data"))));
}

TEST_F(DataDirectoryTest, RefusesAFolderThatHoldsNoData) {
  EXPECT_THAT(
      [&] {
        (void)FindDataDirectory({root_ / "bin/panda-twin", root_, {}});
      },
      ThrowsMessage<InputError>(HasSubstr("has no folder robots")));
  Make("models/robots");
  EXPECT_THAT(
      [&] {
        (void)FindDataDirectory({root_ / "bin/x", root_ / "models", root_});
      },
      ThrowsMessage<InputError>(HasSubstr("has no folder meshes")));
}

}  // namespace
}  // namespace twin::scenario::data_directory_test
