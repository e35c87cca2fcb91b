#include <cmath>
#include <fstream>
#include <memory>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <nlohmann/json.hpp>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::plant::plant_model_test {
namespace {

using DataCopy = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

/// The plant's data, free to be changed.
DataCopy Copy(const MujocoPlant& plant) {
  return {mj_copyData(nullptr, &plant.model(), &plant.data()), &mj_deleteData};
}

MujocoPlantOptions MeshOptions() {
  MujocoPlantOptions options = DefaultOptions();
  options.mesh_package = MeshPackage();
  return options;
}

int BodyId(const MujocoPlant& plant, const std::string& name) {
  return mj_name2id(&plant.model(), mjOBJ_BODY, name.c_str());
}

// The reference is written with 12 digits, hence the tolerance; the two differ by 2e-10 Nm.
TEST(PlantModelTest, GravityEqualsTheRobotsOwnModel) {
  const auto reference =
      nlohmann::json::parse(ReadText(SourceDir() / "tests" / "data" / "model_reference.json"));
  const auto plant = MujocoPlant::Create(BareOptions());
  int checked = 0;
  for (const auto& sample : reference.at("samples")) {
    if (sample.at("load") != "none") continue;
    const JointVector g = plant->GravityTorque(sample.at("q").get<JointVector>());
    const auto expected = sample.at("g").get<JointVector>();
    for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(g[i], expected[i], 1e-9) << checked;
    ++checked;
  }
  EXPECT_GE(checked, 60);
}

TEST(PlantModelTest, FlangeIsWhereTheRobotsOwnModelHasIt) {
  const auto reference =
      nlohmann::json::parse(ReadText(SourceDir() / "tests" / "data" / "model_reference.json"));
  const auto plant = MujocoPlant::Create(BareOptions());
  const int flange = BodyId(*plant, "panda_link8");
  for (const auto& sample : reference.at("samples")) {
    plant->Reset(sample.at("q").get<JointVector>());
    const auto O_T_F = sample.at("O_T_F").get<Transform>();
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(plant->data().xpos[3 * flange + row], O_T_F[12 + row], 1e-10);
      for (int column = 0; column < 3; ++column) {
        EXPECT_NEAR(plant->data().xmat[9 * flange + 3 * row + column], O_T_F[4 * column + row],
                    1e-10);
      }
    }
  }
}

// Sum of links 1 to 7 of Franka's own model, and link 0; the hand weighs 0.73 kg.
TEST(PlantModelTest, WeighsWhatTheUrdfSays) {
  const double links = 4.9706751871147938 + 0.64712411452542207 + 3.2283417206016849 +
                       3.5877058164189872 + 1.2258764841419181 + 1.6660195957719575 +
                       0.73598318978014388;
  const auto bare = MujocoPlant::Create(BareOptions());
  EXPECT_NEAR(bare->model().body_subtreemass[0], 0.629769 + links, 1e-12);
  const auto with_hand = MujocoPlant::Create(DefaultOptions());
  EXPECT_NEAR(with_hand->model().body_subtreemass[BodyId(*with_hand, "panda_link1")], links + 0.73,
              1e-12);
}

TEST(PlantModelTest, StepsAreOneMillisecondWhateverTheSceneSays) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  options.scene =
      folder.Write("scene.xml", "<mujoco><option timestep='0.01' integrator='RK4'/></mujoco>");
  const auto plant = MujocoPlant::Create(options);
  plant->Step({});
  EXPECT_EQ(plant->model().opt.timestep, 0.001);
  EXPECT_EQ(plant->data().time, 0.001);
}

TEST(PlantModelTest, ScenesAngleUnitAndDefaultsDoNotReachTheRobot) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  const auto plain = MujocoPlant::Create(options);
  options.scene = folder.Write(
      "scene.xml",
      "<mujoco><compiler angle='radian'/><default><geom contype='0' rgba='1 0 0 1'/><joint "
      "damping='3'/><mesh scale='2 2 2'/></default></mujoco>");
  const auto plant = MujocoPlant::Create(options);
  for (int i = 0; i < 14; ++i) EXPECT_EQ(plant->model().jnt_range[i], plain->model().jnt_range[i]);
  EXPECT_EQ(plant->model().jnt_range[6], -3.0718);
  EXPECT_EQ(plant->model().jnt_range[7], -0.0698);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(plant->model().dof_damping[i], 0);
  EXPECT_EQ(plant->model().ngeom, plain->model().ngeom - 1);  // less the built-in floor
  for (int i = 0; i < plant->model().ngeom; ++i) {
    EXPECT_EQ(plant->model().geom_contype[i], plant->model().geom_group[i] == 3 ? 1 : 0);
  }
}

TEST(PlantModelTest, MeshesComeFromThePackage) {
  if (!std::filesystem::exists(MeshPackage())) GTEST_SKIP() << "missing: the arm's meshes";
  const auto plant = MujocoPlant::Create(MeshOptions());
  EXPECT_TRUE(plant->uses_meshes());
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
  // Franka's visual meshes have 134300 triangles; decimated they are still what one sees.
  EXPECT_GT(plant->model().nmeshface, 20'000);
  EXPECT_LT(plant->model().nmeshface, 50'000);
  // The model has to stay small: source copies of the meshes are dropped.
  EXPECT_LT(plant->model().nbuffer, 8'000'000);
  std::size_t dark = 0;
  for (int i = 0; i < plant->model().nmat; ++i) dark += plant->model().mat_rgba[4 * i] < 0.3f;
  EXPECT_GE(dark, 1u);
}

TEST(PlantModelTest, VisualErrorOfZeroKeepsTheMeshesAsTheyAre) {
  if (!std::filesystem::exists(MeshPackage())) GTEST_SKIP() << "missing: the arm's meshes";
  MujocoPlantOptions options = MeshOptions();
  options.visual_error = 0;
  EXPECT_GT(MujocoPlant::Create(options)->model().nmeshface, 134'300);
}

TEST(PlantModelTest, VisualErrorMovesNoCollisionMesh) {
  if (!std::filesystem::exists(MeshPackage())) GTEST_SKIP() << "missing: the arm's meshes";
  MujocoPlantOptions options = MeshOptions();
  const auto fewer = MujocoPlant::Create(options);
  options.visual_error = 0;
  const auto all = MujocoPlant::Create(options);
  const mjModel& a = fewer->model();
  const mjModel& b = all->model();
  ASSERT_EQ(a.ngeom, b.ngeom);
  for (int i = 0; i < a.ngeom; ++i) {
    const int mesh = a.geom_dataid[i];
    if (a.geom_group[i] != 3 || mesh < 0) continue;
    ASSERT_EQ(a.mesh_vertnum[mesh], b.mesh_vertnum[mesh]);
    for (int k = 0; k < 3 * a.mesh_vertnum[mesh]; ++k) {
      ASSERT_EQ(a.mesh_vert[3 * a.mesh_vertadr[mesh] + k],
                b.mesh_vert[3 * b.mesh_vertadr[mesh] + k]);
    }
  }
}

TEST(PlantModelTest, RefusesAVisualErrorOutOfRange) {
  MujocoPlantOptions options = DefaultOptions();
  options.visual_error = -1e-3;
  EXPECT_THROW(static_cast<void>(MujocoPlant::Create(options)), InputError);
  options.visual_error = 0.1;
  EXPECT_THROW(static_cast<void>(MujocoPlant::Create(options)), InputError);
}

// Each costs every picture two more passes (src/render/README.md).
TEST(PlantModelTest, EveryOwnSceneHasOneLightThatCastsShadows) {
  const std::filesystem::path scenes = TWIN_SOURCE_DIR "/models/scenes";
  for (const auto& scene : std::filesystem::directory_iterator(scenes)) {
    MujocoPlantOptions options = DefaultOptions();
    options.scene = scene.path();
    const auto plant = MujocoPlant::Create(options);
    int casting = 0;
    for (int i = 0; i < plant->model().nlight; ++i) casting += plant->model().light_castshadow[i];
    EXPECT_EQ(casting, 1) << scene.path();
  }
}

TEST(PlantModelTest, NothingTouchesAtTheReadyPose) {
  EXPECT_EQ(MujocoPlant::Create(DefaultOptions())->data().ncon, 0);
  if (!std::filesystem::exists(MeshPackage())) GTEST_SKIP() << "missing: the arm's meshes";
  EXPECT_EQ(MujocoPlant::Create(MeshOptions())->data().ncon, 0);
}

/// Number of the arm's link that carries `geom`; the hand and its fingers count as link 7.
int LinkOf(const mjModel& model, int geom) {
  const std::string name = mj_id2name(&model, mjOBJ_BODY, model.geom_bodyid[geom]);
  return name.starts_with("panda_link") ? std::stoi(name.substr(10)) : 7;
}

/// Links of the pairs in contact at 1000 poses spread over the joint ranges, the floor left out.
void ExpectOnlyDistantLinksTouch(const MujocoPlant& plant) {
  const auto data = Copy(plant);
  const mjModel& model = plant.model();
  const Random random(1, RandomStream::kTest);
  for (std::uint64_t pose = 0; pose < 1000; ++pose) {
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      const double low = model.jnt_range[2 * i];
      data->qpos[i] = low + (model.jnt_range[2 * i + 1] - low) * random.Uniform(pose, i);
    }
    mj_kinematics(&model, data.get());
    mj_comPos(&model, data.get());
    mj_collision(&model, data.get());
    for (int c = 0; c < data->ncon; ++c) {
      const mjContact& contact = data->contact[c];
      if (model.geom_bodyid[contact.geom1] == 0 || model.geom_bodyid[contact.geom2] == 0) continue;
      EXPECT_GT(std::abs(LinkOf(model, contact.geom1) - LinkOf(model, contact.geom2)), 2);
    }
  }
}

TEST(PlantModelTest, LinksNextToOneAnotherNeverTouch) {
  ExpectOnlyDistantLinksTouch(*MujocoPlant::Create(DefaultOptions()));
  if (!std::filesystem::exists(MeshPackage())) GTEST_SKIP() << "missing: the arm's meshes";
  ExpectOnlyDistantLinksTouch(*MujocoPlant::Create(MeshOptions()));
}

TEST(PlantModelTest, EveryLinkIsABodyAndTheSceneHasItsCamera) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  for (int i = 0; i <= 8; ++i) EXPECT_GT(BodyId(*plant, "panda_link" + std::to_string(i)), 0);
  for (const char* name : {"panda_hand", "panda_leftfinger", "panda_rightfinger"}) {
    EXPECT_GT(BodyId(*plant, name), 0);
  }
  EXPECT_GE(mj_name2id(&plant->model(), mjOBJ_CAMERA, "overview"), 0);
}

}  // namespace
}  // namespace twin::plant::plant_model_test
