#include "twin/plant/observers.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "render/test_model.h"
#include "support/realtime_guard.h"

namespace twin::plant::plant_scene_capture_test {
namespace {

using render::TestModel;

constexpr std::string_view kBallOnFloor = R"(<mujoco><worldbody>
  <geom type="plane" size="1 1 0.1"/>
  <body name="ball" pos="0.3 0.2 0.0499"><freejoint/><geom type="sphere" size="0.05" mass="2"/></body>
</worldbody></mujoco>)";

TEST(SceneCaptureTest, AThingThatLiesOnTheFloorIsBorneByItsWeight) {
  TestModel model(kBallOnFloor);
  for (int i = 0; i < 3000; ++i) model.Step();
  record::SceneRecord scene;
  CaptureScene(Time(std::chrono::seconds(3)), model, scene);
  EXPECT_EQ(scene.at, Time(std::chrono::seconds(3)));
  ASSERT_EQ(scene.contacts, 1U);
  EXPECT_NEAR(scene.contact[0].force_W[2], 2 * 9.81, 1e-3);  // on the ball, upwards
  EXPECT_NEAR(scene.contact[0].p_W[0], 0.3, 1e-6);
  EXPECT_NEAR(scene.contact[0].p_W[2], 0, 1e-3);
  EXPECT_EQ(scene.pushes, 0U);
  ASSERT_EQ(scene.positions, 7U);
  EXPECT_EQ(scene.qpos[0], model.Qpos()[0]);
}

TEST(SceneCaptureTest, APushIsWhereItsForceActs) {
  TestModel model(kBallOnFloor);
  // 10 N along x at a point 3 cm above the centre of mass: M = r x F = (0, 0.3, 0) Nm.
  model.Push(1, {10, 0, 0, 0, 0.3, 0});
  record::SceneRecord scene;
  CaptureScene(Time(), model, scene);
  ASSERT_EQ(scene.pushes, 1U);
  EXPECT_EQ(scene.push[0].force_W, (Vector3{10, 0, 0}));
  EXPECT_NEAR(scene.push[0].p_W[0], 0.3, 1e-12);
  EXPECT_NEAR(scene.push[0].p_W[2], 0.0499 + 0.03, 1e-12);
}

TEST(SceneCaptureTest, ATorqueAloneIsNoPush) {
  TestModel model(kBallOnFloor);
  model.Push(1, {0, 0, 0, 0, 0.3, 0});
  record::SceneRecord scene;
  CaptureScene(Time(), model, scene);
  EXPECT_EQ(scene.pushes, 0U);
}

TEST(SceneCaptureTest, FreeBodiesAreWhereThePositionsSay) {
  const TestModel model(kBallOnFloor);
  // A quarter turn about z: the body's x axis is the world's y.
  const double h = std::sqrt(0.5);
  const auto bodies = FreeBodies(model.model(), std::vector<double>{1, 2, 3, h, 0, 0, h});
  ASSERT_EQ(bodies.size(), 1U);
  EXPECT_EQ(bodies[0].first, "ball");
  const Transform expected{0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(bodies[0].second[i], expected[i], 1e-12) << i;
  }
}

TEST(SceneCaptureTest, AllocatesNothing) {
  TestModel model(kBallOnFloor);
  for (int i = 0; i < 100; ++i) model.Step();
  record::SceneRecord scene;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) CaptureScene(Time(), model, scene);
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::plant::plant_scene_capture_test
