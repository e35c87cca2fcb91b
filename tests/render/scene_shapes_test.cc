#include "twin/render/scene_shapes.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "test_model.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::render::scene_shapes_test {
namespace {

using Json = nlohmann::json;

constexpr const char* kScene = R"(<mujoco>
  <visual><headlight ambient="0.1 0.2 0.3" diffuse="0.4 0.5 0.6"/></visual>
  <asset>
    <texture name="sky" type="skybox" builtin="flat" rgb1="1 0.4 0.2" rgb2="0 0.2 0.4" width="8" height="48"/>
    <texture name="tiles" type="2d" builtin="flat" rgb1="0.2 0.4 0.6" width="4" height="2"/>
    <material name="floor" texture="tiles" texrepeat="3 5"/>
    <material name="red" rgba="1 0 0 1" specular="0.25" shininess="0.75"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 2 0  0 0 3"/>
  </asset>
  <worldbody>
    <light dir="0 0.6 -0.8" diffuse="0.7 0.8 0.9" directional="true"/>
    <geom type="plane" size="2 3 0.1" material="floor"/>
    <body pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.5 0 0" quat="0 1 0 0" material="red"/>
      <geom type="mesh" mesh="wedge" rgba="0 1 0 0.5"/>
      <geom type="mesh" mesh="wedge" pos="0 0 1"/>
      <geom type="sphere" size="0.4" group="3"/>
      <geom type="sphere" size="0.5" rgba="1 1 1 0"/>
    </body>
  </worldbody>
</mujoco>)";

/// A file taken apart as the header describes it.
struct Shapes {
  explicit Shapes(std::string text) : file(std::move(text)) {
    std::uint32_t length = 0;
    std::memcpy(&length, file.data(), sizeof length);
    description = Json::parse(file.substr(4, length));
    begin = 4 + length;
  }

  template <typename Value>
  [[nodiscard]] std::vector<Value> Values(std::size_t at, std::size_t count) const {
    std::vector<Value> values(count);
    EXPECT_LE(begin + at + count * sizeof(Value), file.size());
    std::memcpy(values.data(), file.data() + begin + at, count * sizeof(Value));
    return values;
  }

  std::string file;
  Json description;
  std::size_t begin = 0;
};

TEST(SceneShapesTest, HasWhatIsDrawnAndNothingElse) {
  const TestModel model(kScene);
  const Shapes shapes(SceneShapes(model.model()));
  std::vector<std::string> types;
  for (const Json& geom : shapes.description["geoms"]) types.push_back(geom["type"]);
  EXPECT_EQ(types, (std::vector<std::string>{"plane", "box", "mesh", "mesh"}));
  EXPECT_EQ(shapes.description["bodies"], 2);
  EXPECT_EQ(shapes.description["left_out"], 0);
}

TEST(SceneShapesTest, SaysWhereAShapeIsAndHowItLooks) {
  const TestModel model(kScene);
  const Json box = Shapes(SceneShapes(model.model())).description["geoms"][1];
  EXPECT_EQ(box["body"], 1);
  EXPECT_EQ(box["size"], Json({0.1, 0.2, 0.3}));
  EXPECT_EQ(box["pos"], Json({0.5, 0, 0}));
  EXPECT_EQ(box["quat"], Json({0, 1, 0, 0}));
  EXPECT_EQ(box["colour"], Json({1, 0, 0, 1}));
  EXPECT_EQ(box["specular"], 0.25);
  EXPECT_EQ(box["shininess"], 0.75);
}

TEST(SceneShapesTest, HasLightsAndSkyAndTheFloorsTexture) {
  const TestModel model(kScene);
  const Shapes shapes(SceneShapes(model.model()));
  const Json& all = shapes.description;
  EXPECT_EQ(all["ambient"], Json({0.1, 0.2, 0.3}));
  EXPECT_EQ(all["headlight"], Json({0.4, 0.5, 0.6}));
  ASSERT_EQ(all["lights"].size(), 1U);
  EXPECT_EQ(all["lights"][0]["to"], Json({0, 0.6, -0.8}));
  EXPECT_EQ(all["lights"][0]["colour"], Json({0.7, 0.8, 0.9}));
  EXPECT_NEAR(all["sky"][0][0], 1, 0.01);
  ASSERT_EQ(all["textures"].size(), 1U);
  EXPECT_EQ(all["geoms"][0]["texture"], 0);
  EXPECT_EQ(all["geoms"][0]["repeat"], Json({3, 5}));
  EXPECT_EQ(all["textures"][0]["width"], 4);
  const auto pixels = shapes.Values<std::uint8_t>(all["textures"][0]["at"], 3 * 4 * 2);
  EXPECT_NEAR(pixels[0], 0.2 * 255, 1);
  EXPECT_NEAR(pixels[2], 0.6 * 255, 1);
}

TEST(SceneShapesTest, SaysHowManyHeightFieldsAreMissing) {
  const TestModel model(R"(<mujoco>
    <asset><hfield name="hill" nrow="2" ncol="2" size="1 1 1 0.1"/></asset>
    <worldbody><geom type="hfield" hfield="hill"/></worldbody>
  </mujoco>)");
  const Json all = Shapes(SceneShapes(model.model())).description;
  EXPECT_EQ(all["left_out"], 1);
  EXPECT_TRUE(all["geoms"].empty());
  EXPECT_TRUE(all["sky"].is_null());
}

/// Least and largest coordinates of the vertices.
std::array<std::array<float, 3>, 2> Bounds(const float* vertices, std::size_t count) {
  std::array<std::array<float, 3>, 2> bounds{{{1e9F, 1e9F, 1e9F}, {-1e9F, -1e9F, -1e9F}}};
  for (std::size_t i = 0; i < 3 * count; ++i) {
    bounds[0][i % 3] = std::min(bounds[0][i % 3], vertices[i]);
    bounds[1][i % 3] = std::max(bounds[1][i % 3], vertices[i]);
  }
  return bounds;
}

#ifdef TWIN_MESH_PACKAGE
constexpr const char* kMeshPackage = TWIN_MESH_PACKAGE;
#else
constexpr const char* kMeshPackage = "";
#endif

// The arm that runs use: with its meshes where scripts/setup has fetched them.
TEST(SceneShapesTest, HasTheArmsMeshesOnceEachAndWhole) {
  plant::MujocoPlantOptions options;
  options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  options.scene = TWIN_SOURCE_DIR "/models/scenes/table_box.xml";
  options.mesh_package = kMeshPackage;
  const auto plant = plant::MujocoPlant::Create(options);
  const mjModel& model = plant->model();
  const Shapes shapes(SceneShapes(model));
  const Json& all = shapes.description;
  EXPECT_EQ(all["bodies"], model.nbody);
  EXPECT_EQ(all["base"], mj_name2id(&model, mjOBJ_BODY, "panda_link0"));
  std::map<int, int> mesh_of;  // by the file's index: the model's
  std::size_t n = 0;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (model.geom_group[geom] > 2) continue;
    ASSERT_LT(n, all["geoms"].size());
    const Json& written = all["geoms"][n++];
    EXPECT_EQ(written["body"], model.geom_bodyid[geom]);
    if (model.geom_type[geom] != mjGEOM_MESH) continue;
    const auto [known, is_new] = mesh_of.emplace(written["mesh"], model.geom_dataid[geom]);
    EXPECT_EQ(known->second, model.geom_dataid[geom]);
  }
  EXPECT_EQ(n, all["geoms"].size());
  EXPECT_EQ(mesh_of.size(), all["meshes"].size());
  if (plant->uses_meshes()) {
    EXPECT_GT(mesh_of.size(), 20U);
  }
  for (const auto& [index, mesh] : mesh_of) {
    const Json& written = all["meshes"][static_cast<std::size_t>(index)];
    const std::size_t vertices = written["vertices"];
    const std::size_t faces = written["faces"];
    ASSERT_EQ(vertices, static_cast<std::size_t>(model.mesh_vertnum[mesh]));
    ASSERT_EQ(faces, static_cast<std::size_t>(model.mesh_facenum[mesh]));
    const std::size_t at = written["at"];
    EXPECT_EQ(Bounds(shapes.Values<float>(at, 3 * vertices).data(), vertices),
              Bounds(model.mesh_vert + std::ptrdiff_t{3} * model.mesh_vertadr[mesh], vertices));
    for (const float part : shapes.Values<float>(at + 12 * vertices, 3 * vertices)) {
      EXPECT_LE(std::abs(part), 1.0001F);
    }
    for (const std::uint32_t corner : shapes.Values<std::uint32_t>(at + 24 * vertices, 3 * faces)) {
      EXPECT_LT(corner, vertices);
    }
  }
}

TEST(BodyPosesTest, FollowTheModelsKinematics) {
  const TestModel model(kScene);
  BodyPoses poses(model.model());
  const double half = std::sqrt(0.5);
  const std::vector<double> qpos{1, 2, 3, half, 0, 0, half};
  const auto at = poses.At(qpos);
  ASSERT_EQ(at.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(at[i], qpos[i], 1e-12) << i;
}

}  // namespace
}  // namespace twin::render::scene_shapes_test
