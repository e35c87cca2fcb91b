// The pictures of the canonical run against our own model: in five key frames, seen by the
// scenario's own camera, the mask of every link contains the projection of the frame origin that
// the model computes.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "twin/plant/mujoco_plant.h"
#include "twin/render/link_mask.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::render::canonical_frames_test {
namespace {

constexpr double kMaxDistancePx = 2;
constexpr int kKeyFrames = 5;

TEST(CanonicalFramesTest, EveryLinkIsDrawnWhereTheModelComputesIt) {
  const std::filesystem::path models = TWIN_SOURCE_DIR "/models";
  const scenario::Scenario canonical = scenario::Load(models / "scenarios/canonical.yaml");
  const scenario::RobotData robot =
      scenario::LoadRobotData(models, canonical.robot.model, canonical.robot.hand);
  const reference::Trajectory trajectory = run::MakeTrajectory(canonical, robot);
  run::RunFiles files;
  files.models = models;
#ifdef TWIN_MESH_PACKAGE
  files.mesh_package = TWIN_MESH_PACKAGE;
#endif
  const auto plant =
      plant::MujocoPlant::Create(run::MakeRobotConfig(canonical, robot, files).plant);
  RenderSettings settings;
  settings.width = canonical.render.width;
  settings.height = canonical.render.height;
  settings.camera = canonical.render.camera.name;
  Renderer renderer(plant->model(), settings);

  for (int frame = 0; frame < kKeyFrames; ++frame) {
    const Duration at = trajectory.duration() * frame / kKeyFrames;
    const JointVector q = trajectory.Sample(at).q;
    plant->Reset(q);
    std::vector<double> qpos(plant->qpos_size());
    plant->CopyQpos(qpos);
    const auto checks = CheckLinkMasks(renderer, qpos, ArmLinkPoints(renderer, q));
    ASSERT_EQ(checks.size(), 9U);
    for (const LinkMaskCheck& check : checks) {
      ASSERT_TRUE(check.distance_px) << check.name;
      EXPECT_LE(*check.distance_px, kMaxDistancePx)
          << check.name << " at " << ToSeconds(at) << " s";
    }
  }
}

}  // namespace
}  // namespace twin::render::canonical_frames_test
