#include "twin/plant/object_watch.h"

#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "twin/plant/contact_watch.h"

namespace twin::plant::plant_object_watch_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1ms

Transform At(double x, double y, double z) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
}

/// A ball 50 mm above a stand; a brick on a column, between the open fingers.
std::unique_ptr<MujocoPlant> MakePlant() {
  MujocoPlantOptions options = DefaultOptions();
  options.objects = {
      {.name = "stand", .size = {0.2, 0.2, 0.2}, .X_WB = At(0.6, 0.4, 0.1)},
      {.name = "ball",
       .shape = ObjectShape::kSphere,
       .size = {0.06, 0.06, 0.06},
       .mass = 0.1,
       .X_WB = At(0.6, 0.4, 0.28)},
      {.name = "column", .size = {0.03, 0.03, 0.4669}, .X_WB = At(0.307, 0, 0.23345)},
      {.name = "brick", .size = {0.04, 0.04, 0.04}, .mass = 0.1, .X_WB = At(0.307, 0, 0.4869)}};
  return MujocoPlant::Create(options);
}

/// Steps with the arm on its brakes and the hand closing.
void Step(MujocoPlant& plant, ObjectWatch& watch, int steps) {
  JointDrive drive;
  drive.brakes = true;
  for (int k = 1; k <= steps; ++k) {
    plant.hand()->Drive({.force = -30, .width_d = 0});
    drive.tau = plant.GravityTorque(plant.sensors().q);
    plant.Step(drive);
    watch.Look(Time(k * 1ms));
  }
}

TEST(ObjectWatchTest, SeesAFallAndItsEnd) {
  const auto plant = MakePlant();
  plant->Reset(kReady);
  ObjectWatch watch(*plant);
  Step(*plant, watch, 1000);
  const std::vector<ObjectTrack> tracks = watch.Tracks();
  ASSERT_EQ(tracks.size(), 2U);
  const ObjectTrack& ball = tracks[0];
  EXPECT_EQ(ball.body, "ball");
  EXPECT_TRUE(ball.changes.at(0).now.none());
  EXPECT_EQ(ball.changes.at(0).at, Time(1ms));
  // 50 mm of free fall.
  const double fall_s = std::sqrt(2 * 0.05 / 9.81);
  EXPECT_TRUE(ball.changes.at(1).now.world);
  EXPECT_NEAR(ToSeconds(ball.changes[1].at.time_since_epoch()), fall_s, 3e-3);
  ASSERT_EQ(ball.touched.size(), 1U);
  EXPECT_EQ(ball.touched[0].part, "stand");
  EXPECT_EQ(ball.touched[0].first, ball.changes[1].at);
  EXPECT_EQ(ball.samples.size(), 100U);
  EXPECT_NEAR(ball.samples[5].speed, 9.81 * 0.051, 0.02);
  EXPECT_NEAR(ball.last.X_WB[14], 0.23, 2e-3);
}

TEST(ObjectWatchTest, SeesWhatTheFingersHold) {
  const auto plant = MakePlant();
  plant->Reset(kReady);
  ObjectWatch watch(*plant);
  Step(*plant, watch, 2000);
  const ObjectTrack brick = watch.Tracks().at(1);
  EXPECT_EQ(brick.missed_changes, 0U);
  EXPECT_FALSE(brick.changes.at(0).now.left_finger);
  const Support end = brick.changes.back().now;
  EXPECT_TRUE(end.between_fingers());
  EXPECT_TRUE(end.world);
  EXPECT_FALSE(end.robot);
  ASSERT_EQ(brick.touched.size(), 1U);
  EXPECT_EQ(brick.touched[0].part, "column");
  EXPECT_EQ(brick.touched[0].last, Time(2s));
}

TEST(ObjectWatchTest, IsLookedAtWithTheContacts) {
  const auto plant = MakePlant();
  plant->Reset(kReady);
  ContactWatch contacts(*plant);
  contacts.Look(Time(1ms));
  const std::vector<ObjectTrack> tracks = contacts.objects().Tracks();
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_EQ(tracks[1].body, "brick");
  EXPECT_EQ(tracks[1].last.at, Time(1ms));
  // The hand's frame is 0.1034 m behind its tips, and looks down.
  EXPECT_NEAR(tracks[1].last.X_HB[14], 0.1034, 2e-3);
}

}  // namespace
}  // namespace twin::plant::plant_object_watch_test
