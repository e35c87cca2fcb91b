#include "twin/render/frame_painter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "render/test_model.h"
#include "twin/core/error.h"
#include "twin/render/pinhole_camera.h"

namespace twin::render::frame_painter_test {
namespace {

using std::chrono::milliseconds;

/// A chain with the names of the Panda's joints, each 0.1 m above the last, that all turn about z,
/// and a free box; a wall whose face is the plane x = 2 behind them.
std::string ChainMjcf() {
  std::string open;
  std::string close;
  for (int i = 1; i <= 7; ++i) {
    const std::string n = std::to_string(i);
    open.append("<body name='panda_link").append(n);
    open.append("' pos='0 0 0.1'><joint name='panda_joint").append(n);
    open += "' axis='0 0 1' range='-2 2' limited='true'/><geom type='box' size='0.03 0.02 0.04'/>";
    close += "</body>";
  }
  return "<mujoco><visual><headlight ambient='1 1 1' diffuse='0 0 0' specular='0 0 0'/></visual>"
         "<worldbody><geom name='wall' type='box' pos='2.5 0 0' size='0.5 5 5' rgba='1 1 1 1'/>" +
         open + "<body name='tool' pos='0 0 0.25'><geom type='sphere' size='0.02'/></body>" +
         close +
         "<body name='parcel' pos='0 0.4 0.4'><freejoint/><geom type='box' size='0.05 0.05 0.05' "
         "rgba='0.5 0.5 0.5 1'/></body></worldbody></mujoco>";
}

class FramePainterTest : public testing::Test {
 protected:
  FramePainterTest()
      : model_(ChainMjcf()),
        snapshots_(10, model_.qpos_size()),
        film_{&model_.model(), &snapshots_} {
    settings_.render.width = 320;
    settings_.render.height = 240;
    settings_.render.shadows = false;
    settings_.overlays = {.text = false};
    settings_.view.orbit = {.azimuth_deg = 0,
                            .elevation_deg = 0,
                            .distance_m = 1.5,
                            .lookat_m = {0, 0, 0.5}};  // looks along +x
    record::SceneRecord scene;
    scene.positions = static_cast<std::uint32_t>(model_.qpos_size());
    const std::vector<double> qpos = model_.Qpos();
    std::copy(qpos.begin(), qpos.end(), scene.qpos.begin());
    for (int i = 0; i < 5; ++i) {
      scene.at = Time(milliseconds(100 * i));
      snapshots_.Append(scene);
      scene.qpos[kParcelY] += 0.01;
    }
  }

  Image Paint(std::size_t frame = 0) { return FramePainter(film_, settings_).Paint(frame); }

  /// Replaces the last frame's record.
  void Last(const record::SceneRecord& scene) {
    Snapshots changed(snapshots_.fps(), snapshots_.qpos_size());
    for (std::size_t i = 0; i + 1 < snapshots_.size(); ++i) changed.Append(snapshots_.scene(i));
    changed.Append(scene);
    snapshots_ = changed;
  }

  [[nodiscard]] Rgb PixelAt(const Image& image, const Vector3& p_W) const {
    const PinholeCamera camera = PinholeCamera::FromFreeCamera(
        settings_.view.orbit, model_.model().vis.global.fovy, image.width, image.height);
    const PixelPoint pixel = camera.Project(p_W).value();
    return image.at(static_cast<int>(pixel.u), static_cast<int>(pixel.v));
  }

  static constexpr std::size_t kParcelY = 8;  // after seven hinges: x, y, z, quaternion

  TestModel model_;
  Snapshots snapshots_;
  Film film_;
  FilmSettings settings_;
};

/// Pixels that differ, within and outside a rectangle (from the left, from the top).
struct Changes {
  int inside = 0;
  int outside = 0;
};
Changes ChangesOf(const Image& a, const Image& b, int left, int top, int right, int bottom) {
  Changes changes;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      if (a.at(x, y) == b.at(x, y)) continue;
      const bool inside = x >= left && x < right && y >= top && y < bottom;
      ++(inside ? changes.inside : changes.outside);
    }
  }
  return changes;
}

bool IsReddish(const Rgb& c) {
  return c[0] > c[1] + 60 && c[0] > c[2] + 60;
}

TEST_F(FramePainterTest, DrawsAFrameTheSameWhateverWasDrawnBefore) {
  settings_.overlays = {true, true, true, true, true, true};
  FramePainter painter(film_, settings_);
  const Image first = painter.Paint(3);
  static_cast<void>(painter.Depth(1));
  static_cast<void>(painter.Segment(2));
  static_cast<void>(painter.Paint(0));
  EXPECT_EQ(painter.Paint(3), first);
  EXPECT_EQ(FramePainter(film_, settings_).Paint(3), first);
}

TEST_F(FramePainterTest, MeasuresDistancesAlongTheCamerasAxis) {
  const DepthImage depth = FramePainter(film_, settings_).Depth(0);
  EXPECT_NEAR(depth.at(10, 20), 3.5, 1e-4);     // the wall, far off the axis
  EXPECT_NEAR(depth.at(160, 120), 1.47, 1e-4);  // the chain's middle, 3 cm thick each way
}

TEST_F(FramePainterTest, ShowsNothingFarAwayAsBackground) {
  settings_.view.orbit.azimuth_deg = 180;  // away from the wall
  EXPECT_EQ(FramePainter(film_, settings_).Depth(0).at(5, 5), DepthImage::kBackground);
}

TEST_F(FramePainterTest, TellsTheBodyOfEachPixel) {
  const SegmentationImage bodies = FramePainter(film_, settings_).Segment(0);
  EXPECT_EQ(bodies.at(5, 5), 0);
  EXPECT_EQ(bodies.at(160, 120), 5);  // panda_link5 is at a height of 0.5 m
}

TEST_F(FramePainterTest, PutsAnInsetIntoItsCornerAndNowhereElse) {
  const Image plain = Paint();
  settings_.insets.push_back({.view = {.kind = ViewKind::kGripper, .name = {}, .orbit = {}},
                              .corner = Corner::kBottomLeft,
                              .share = 0.25});
  const Changes changes = ChangesOf(plain, Paint(), 4, 240 - 68, 88, 236);
  EXPECT_GT(changes.inside, 1000);
  EXPECT_EQ(changes.outside, 0);
}

TEST_F(FramePainterTest, RefusesTwoInsetsInOneCorner) {
  const Inset gripper{.view = {.kind = ViewKind::kGripper, .name = {}, .orbit = {}}};
  settings_.insets = {gripper, gripper};
  EXPECT_THROW(static_cast<void>(Paint()), InputError);
  settings_.insets[1].corner = Corner::kBottomRight;
  EXPECT_NO_THROW(static_cast<void>(Paint()));
}

TEST_F(FramePainterTest, TheGrippersCameraHasTheToolInTheMiddle) {
  settings_.view.kind = ViewKind::kGripper;
  for (const double turn : {0.0, 1.0}) {
    record::SceneRecord scene = snapshots_.scene(0);
    scene.qpos[6] = turn;
    Last(scene);
    const SegmentationImage bodies = FramePainter(film_, settings_).Segment(snapshots_.size() - 1);
    // The tool's ball is 25 cm along the flange's axis, the camera looks 20.5 cm along it from 9
    // cm aside and 9 cm along: the ball is in the lower half, never left or right.
    int left = 0;
    int right = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 160; ++x) {
        left += bodies.at(x, y) == 8 ? 1 : 0;
        right += bodies.at(319 - x, y) == 8 ? 1 : 0;
      }
    }
    EXPECT_GT(left, 100);
    EXPECT_NEAR(left, right, 0.05 * left + 8);
  }
}

TEST_F(FramePainterTest, ATrackingCameraKeepsItsBodyInTheMiddle) {
  settings_.view.kind = ViewKind::kTracking;
  settings_.view.name = "parcel";
  settings_.view.orbit.lookat_m = {};
  FramePainter painter(film_, settings_);
  for (const std::size_t frame : {0U, 4U}) {
    EXPECT_EQ(painter.Segment(frame).at(160, 120), 9) << frame;
  }
}

TEST_F(FramePainterTest, ACameraThatTurnsAlongSeesItsBodyAsBefore) {
  settings_.view.kind = ViewKind::kTracking;
  settings_.view.name = "parcel";
  settings_.view.turns_along = true;
  settings_.view.orbit.lookat_m = {0.05, 0.02, 0};
  settings_.view.orbit.azimuth_deg = 20;
  settings_.view.orbit.distance_m = 0.4;
  record::SceneRecord scene = snapshots_.scene(4);
  scene.qpos[10] = std::cos(0.35);  // the parcel's quaternion: turned by 0.7 rad about z
  scene.qpos[13] = std::sin(0.35);
  snapshots_.Append(scene);
  FramePainter painter(film_, settings_);
  const SegmentationImage before = painter.Segment(0);
  const SegmentationImage turned = painter.Segment(5);
  int seen = 0;
  int differ = 0;
  for (std::size_t i = 0; i < before.body.size(); ++i) {
    seen += before.body[i] == 9 ? 1 : 0;
    differ += (before.body[i] == 9) != (turned.body[i] == 9) ? 1 : 0;
  }
  EXPECT_GT(seen, 1000);
  EXPECT_LT(differ, seen / 100);
}

TEST_F(FramePainterTest, AnOrbitTurnsByTheRunsTime) {
  settings_.view.turn_deg_per_s = 100;
  const Image turned = Paint(4);  // 0.4 s
  settings_.view.turn_deg_per_s = 0;
  settings_.view.orbit.azimuth_deg = 40;
  EXPECT_EQ(turned, Paint(4));
}

TEST_F(FramePainterTest, AForcesTipIsWhereItActs) {
  settings_.overlays.forces = true;
  record::SceneRecord scene = snapshots_.scene(4);
  scene.contacts = 1;
  scene.contact[0] = {.p_W = {-0.2, -0.3, 0.6}, .force_W = {0, 0, 25}};
  Last(scene);
  const Image image = Paint(4);
  EXPECT_TRUE(IsReddish(PixelAt(image, {-0.2, -0.3, 0.59})));
  EXPECT_TRUE(IsReddish(PixelAt(image, {-0.2, -0.3, 0.51})));  // 25 N are 10 cm
  EXPECT_FALSE(IsReddish(PixelAt(image, {-0.2, -0.3, 0.62})));
  EXPECT_FALSE(IsReddish(PixelAt(image, {-0.2, -0.3, 0.48})));
}

TEST_F(FramePainterTest, APushIsNoContact) {
  settings_.overlays.contacts = true;
  record::SceneRecord scene = snapshots_.scene(4);
  scene.pushes = 1;
  scene.push[0] = {.p_W = {-0.2, -0.3, 0.6}, .force_W = {0, 0, 25}};
  Last(scene);
  const Image without = Paint(4);
  EXPECT_FALSE(IsReddish(PixelAt(without, {-0.2, -0.3, 0.6})));
  scene.contacts = 1;
  scene.contact[0] = scene.push[0];
  Last(scene);
  EXPECT_TRUE(IsReddish(PixelAt(Paint(4), {-0.2, -0.3, 0.6})));
}

TEST_F(FramePainterTest, DrawsAGoalOnlyInItsTimeAndWhereItIs) {
  settings_.overlays.goal = true;
  const Image before = Paint(0);
  PlannedGoal goal;
  goal.from = Time(milliseconds(100));
  goal.until = Time(milliseconds(200));
  goal.object = "parcel";
  goal.O_T_object[12] = -0.1;
  goal.O_T_object[13] = -0.4;
  goal.O_T_object[14] = 0.4;
  film_.goals.push_back(goal);
  EXPECT_EQ(Paint(0), before);
  const Image during = Paint(1);
  const Rgb there = PixelAt(during, {-0.15, -0.4, 0.4});
  EXPECT_GT(there[2], there[0] + 40);  // bluish
  film_.goals.clear();
  EXPECT_NE(Paint(1), during);
}

TEST_F(FramePainterTest, AGoalCanBeGivenWhateverItsTime) {
  PlannedGoal goal;
  goal.q = JointVector{1, 0, 0, 0, 0, 0, 0};
  goal.path = {{-0.3, 0.3, 0.7}};
  const Image image = FramePainter(film_, settings_).Paint(0, goal);
  EXPECT_TRUE(IsReddish(PixelAt(image, {-0.3, 0.3, 0.7})));
}

TEST_F(FramePainterTest, TheTraceIsWhereTheToolWas) {
  settings_.overlays.trace = true;
  settings_.view.orbit.lookat_m = {0, 0, 0.9};
  record::SceneRecord scene = snapshots_.scene(4);
  scene.at = Time(milliseconds(10000));
  Last(scene);
  const Image still = Paint(4);
  settings_.overlays.trace = false;
  EXPECT_EQ(Paint(4), still);  // a tool that does not move leaves none
}

TEST_F(FramePainterTest, ASliderStandsWhereTheJointIsBetweenItsLimits) {
  const Image without = Paint(4);
  settings_.overlays.limits = true;
  record::SceneRecord scene = snapshots_.scene(4);
  scene.qpos[0] = -2;
  scene.qpos[1] = 2;
  Last(scene);
  const Image image = Paint(4);
  // The first two bars: 4 px wide, 40 high, from 5 px above the edge; red at their ends.
  const auto reds = [&](int left, int right, int top, int bottom) {
    int count = 0;
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) count += IsReddish(image.at(x, y)) ? 1 : 0;
    }
    return count;
  };
  const int left = 320 - 7 * 6 - 5;
  EXPECT_GT(reds(left, left + 4, 240 - 5 - 3, 240 - 5), 0);
  EXPECT_EQ(reds(left, left + 4, 190, 240 - 5 - 3), 0);
  EXPECT_GT(reds(left + 6, left + 10, 240 - 45, 240 - 45 + 3), 0);
  EXPECT_NE(image, without);
}

TEST_F(FramePainterTest, RefusesABodyThatTheModelDoesNotHave) {
  settings_.view.kind = ViewKind::kTracking;
  settings_.view.name = "elephant";
  try {
    static_cast<void>(Paint());
    FAIL() << "it was drawn";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("elephant"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("parcel"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace twin::render::frame_painter_test
