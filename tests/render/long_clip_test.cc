// A video of ten minutes: what its making takes in memory.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <span>

#include "support/peak_memory.h"
#include "support/temporary_folder.h"
#include "twin/core/clock.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/render/clip.h"

namespace twin::render::long_clip_test {
namespace {

constexpr std::size_t kFrames = 15'000;
constexpr double kMostMegabytes = 300;

/// The arm, waving.
Snapshots TenMinutes(plant::MujocoPlant& plant) {
  Snapshots snapshots(25, plant.qpos_size());
  for (std::size_t i = 0; i < kFrames; ++i) {
    const double s = 0.5 * std::sin(0.05 * static_cast<double>(i));
    plant.Reset({s, -M_PI / 4 + s, 0, -3 * M_PI / 4, s, M_PI / 2, M_PI / 4});
    record::SceneRecord scene;
    scene.at = Time(std::chrono::milliseconds(40 * i));
    scene.positions = static_cast<std::uint32_t>(plant.qpos_size());
    plant.CopyQpos(std::span(scene.qpos).first(scene.positions));
    snapshots.Append(scene);
  }
  return snapshots;
}

/// Of the largest child that has ended, in bytes.
double PeakMemoryOfChildren() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

TEST(LongClipTest, OfTenMinutesStaysBelow300Megabytes) {
  plant::MujocoPlantOptions options;
  options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  options.scene = TWIN_SOURCE_DIR "/models/scenes/floor.xml";
#ifdef TWIN_MESH_PACKAGE
  options.mesh_package = TWIN_MESH_PACKAGE;
#endif
  const auto plant = plant::MujocoPlant::Create(options);
  const Snapshots snapshots = TenMinutes(*plant);
  ClipSettings settings;
  settings.film.view = {.kind = ViewKind::kScene, .name = "overview", .orbit = {}};
  settings.film.overlays.trace = true;
  settings.film.overlays.limits = true;
  const test::TemporaryFolder folder;

  test::ResetPeakMemory();
  RenderClip({&plant->model(), &snapshots}, settings, {folder / "clip.mp4", folder / "sheet.png"},
             MonotonicClock());

  const double own = static_cast<double>(test::PeakMemory()) / 1e6;
  const double encoder = PeakMemoryOfChildren() / 1e6;
  std::printf("own %.0f MB, encoder %.0f MB\n", own, encoder);
  EXPECT_LT(own, kMostMegabytes);
}

}  // namespace
}  // namespace twin::render::long_clip_test
