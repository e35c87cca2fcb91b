// The arm as it is drawn against the arm as it is computed.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "twin/plant/mujoco_plant.h"
#include "twin/render/link_mask.h"

namespace twin::render::panda_mask_test {
namespace {

constexpr double kMaxDistancePx = 2;

/// The ready pose and four more, far apart in every joint.
constexpr std::array<JointVector, 5> kKeyPoses{{
    {0, -M_PI / 4, 0, -3 * M_PI / 4, 0, M_PI / 2, M_PI / 4},
    {1.2, 0.5, 0.3, -1.5, 0.6, 2.5, 0.2},
    {-1.5, -0.2, -0.8, -2.0, -1.0, 1.2, -0.5},
    {0, 0.2, 0, -0.3, 0, 0.8, 0.78},
    {2.2, 1.1, 1.4, -2.6, 1.8, 3.2, -2.0},
}};

std::unique_ptr<plant::MujocoPlant> MakePlant(const std::filesystem::path& mesh_package) {
  plant::MujocoPlantOptions options;
  options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  options.scene = TWIN_SOURCE_DIR "/models/scenes/floor.xml";
  options.mesh_package = mesh_package;
  return plant::MujocoPlant::Create(options);
}

std::vector<double> QposAt(plant::MujocoPlant& plant, const JointVector& q) {
  plant.Reset(q);
  std::vector<double> qpos(plant.qpos_size());
  plant.CopyQpos(qpos);
  return qpos;
}

void ExpectEveryLinkWhereItIsComputed(const std::filesystem::path& mesh_package) {
  const auto plant = MakePlant(mesh_package);
  ASSERT_EQ(plant->uses_meshes(), !mesh_package.empty());
  for (const double azimuth_deg : {142.0, -60.0}) {
    RenderSettings settings;
    settings.free_camera.azimuth_deg = azimuth_deg;
    Renderer renderer(plant->model(), settings);
    for (const JointVector& q : kKeyPoses) {
      const auto checks = CheckLinkMasks(renderer, QposAt(*plant, q), ArmLinkPoints(renderer, q));
      ASSERT_EQ(checks.size(), 9U);
      for (const LinkMaskCheck& check : checks) {
        ASSERT_TRUE(check.distance_px) << check.name;
        EXPECT_LE(*check.distance_px, kMaxDistancePx)
            << check.name << " at q1 = " << q[0] << ", azimuth " << azimuth_deg;
        EXPECT_GT(check.mask_pixels, 50U) << check.name;
      }
    }
  }
}

TEST(PandaMaskTest, EveryPrimitiveLinkContainsItsFrameOrigin) {
  ExpectEveryLinkWhereItIsComputed({});
}

// Not the seventh: it turns about a line through the flange's origin. The fifth by more than the
// others: what it moves is at most 9 cm from its axis.
TEST(PandaMaskTest, NoticesAnyOfTheFirstSixJointsDrawnElsewhere) {
  constexpr std::array<double, kJoints - 1> kTurns{0.3, 0.3, 0.3, 0.3, 0.8, 0.3};
  const auto plant = MakePlant({});
  Renderer renderer(plant->model(), RenderSettings());
  for (std::size_t joint = 0; joint < kTurns.size(); ++joint) {
    double worst_px = 0;
    for (const JointVector& q : kKeyPoses) {
      JointVector drawn = q;
      drawn[joint] += kTurns[joint];
      for (const LinkMaskCheck& check :
           CheckLinkMasks(renderer, QposAt(*plant, drawn), ArmLinkPoints(renderer, q))) {
        worst_px = std::max(worst_px, check.distance_px.value_or(0));
      }
    }
    EXPECT_GT(worst_px, kMaxDistancePx) << "joint " << joint + 1;
  }
}

#ifdef TWIN_MESH_PACKAGE
TEST(PandaMaskTest, EveryMeshLinkContainsItsFrameOrigin) {
  ExpectEveryLinkWhereItIsComputed(TWIN_MESH_PACKAGE);
}
#endif

}  // namespace
}  // namespace twin::render::panda_mask_test
