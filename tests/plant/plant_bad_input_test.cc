#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"

namespace twin::plant::plant_bad_input_test {
namespace {

using testing::HasSubstr;

template <typename E>
std::string Refusal(const MujocoPlantOptions& options) {
  return MessageOf<E>([&options] { (void)MujocoPlant::Create(options); });
}

std::string RefusalOfScene(const std::string& scene) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  options.scene = folder.Write("scene.xml", scene);
  std::string message = Refusal<InputError>(options);
  EXPECT_THAT(message, HasSubstr(options.scene.string()));
  EXPECT_THAT(message, testing::Not(HasSubstr("\n")));
  return message;
}

TEST(BadInputTest, MissingUrdf) {
  MujocoPlantOptions options = BareOptions();
  options.urdf = "nowhere/panda.urdf";
  EXPECT_THAT(Refusal<InputError>(options), HasSubstr("nowhere/panda.urdf"));
}

TEST(BadInputTest, FolderInPlaceOfTheUrdf) {
  MujocoPlantOptions options = BareOptions();
  options.urdf = SourceDir() / "models";
  EXPECT_THAT(Refusal<InputError>(options), HasSubstr(options.urdf.string()));
}

TEST(BadInputTest, TruncatedUrdf) {
  const TemporaryFolder folder;
  const std::string text = ReadText(BareOptions().urdf);
  MujocoPlantOptions options = BareOptions();
  options.urdf = folder.Write("panda.urdf", text.substr(0, text.size() / 2));
  std::string message = Refusal<InputError>(options);
  EXPECT_THAT(message, HasSubstr(options.urdf.string() + ": not a valid URDF"));
}

TEST(BadInputTest, ArmWithTooFewJoints) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  std::string text = ReadText(options.urdf);
  text.replace(text.find("name=\"panda_joint7\" type=\"revolute\""), 35,
               "name=\"panda_joint7\" type=\"fixed\"   ");
  options.urdf = folder.Write("panda.urdf", text);
  folder.Write("primitives.yaml", ReadText(BareOptions().urdf.parent_path() / "primitives.yaml"));
  EXPECT_THAT(Refusal<InputError>(options), HasSubstr("6 revolute joints"));
}

TEST(BadInputTest, ArmWithASlide) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  std::string text = ReadText(options.urdf);
  const std::string joint = "name=\"panda_joint8\" type=\"fixed\">";
  ASSERT_NE(text.find(joint), std::string::npos);
  text.replace(text.find(joint), joint.size(),
               "name=\"panda_joint8\" type=\"prismatic\">"
               "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>");
  options.urdf = folder.Write("panda.urdf", text);
  folder.Write("primitives.yaml", ReadText(BareOptions().urdf.parent_path() / "primitives.yaml"));
  EXPECT_THAT(Refusal<InputError>(options), HasSubstr("'panda_joint8'"));
}

TEST(BadInputTest, MissingMeshIsNamedWithItsLink) {
  const TemporaryFolder folder;
  folder.Write("meshes/README", "empty but for this");
  MujocoPlantOptions options = BareOptions();
  options.mesh_package = folder.path();
  std::string message = Refusal<InputError>(options);
  EXPECT_THAT(message, HasSubstr("panda.urdf: link 'panda_link0'"));
  EXPECT_THAT(message, HasSubstr((folder.path() / "meshes/visual/link0.dae").string()));
  EXPECT_THAT(message, HasSubstr("scripts/setup"));
}

TEST(BadInputTest, MissingPackageMeansPrimitives) {
  MujocoPlantOptions options = BareOptions();
  options.mesh_package = "nowhere/panda_description";
  EXPECT_FALSE(MujocoPlant::Create(options)->uses_meshes());
}

TEST(BadInputTest, MissingScene) {
  MujocoPlantOptions options = BareOptions();
  options.scene = "nowhere/scene.xml";
  EXPECT_THAT(Refusal<InputError>(options), HasSubstr("nowhere/scene.xml"));
}

TEST(BadInputTest, MalformedScene) {
  RefusalOfScene("<mujoco><worldbody>");
}

TEST(BadInputTest, SceneWithAnUnknownElement) {
  EXPECT_THAT(RefusalOfScene("<mujoco><worldbody><ball/></worldbody></mujoco>"), HasSubstr("ball"));
}

TEST(BadInputTest, SceneThatTakesARobotsName) {
  EXPECT_THAT(RefusalOfScene("<mujoco><worldbody><body name='panda_link3'/></worldbody></mujoco>"),
              HasSubstr("panda_link3"));
}

TEST(BadInputTest, SceneThatWouldChangeTheRobotsMass) {
  EXPECT_THAT(RefusalOfScene("<mujoco><compiler settotalmass='3'/></mujoco>"),
              HasSubstr("changes the robot"));
  EXPECT_THAT(RefusalOfScene("<mujoco><compiler boundmass='9'/></mujoco>"),
              HasSubstr("changes the robot"));
}

TEST(BadInputTest, NothingWritesTheEnginesLog) {
  RefusalOfScene("<mujoco><worldbody><geom type='mesh' mesh='none'/></worldbody></mujoco>");
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

}  // namespace
}  // namespace twin::plant::plant_bad_input_test
