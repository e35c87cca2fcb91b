#include "twin/plant/contact_watch.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant::plant_contact_watch_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1ms

constexpr JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
/// Reaches down before the robot, so far that the hand is in what stands there.
constexpr JointVector kDown{0, 0.6, 0, -2.0, 0, 2.6, 0.7854};

/// Arm and hand on primitive shapes, among boxes on a table; one of them lies there freely.
std::unique_ptr<MujocoPlant> MakePlant() {
  const std::filesystem::path models = TWIN_SOURCE_DIR "/models";
  MujocoPlantOptions options;
  options.urdf = models / "robots" / "panda" / "panda.urdf";
  options.scene = models / "scenes" / "clutter.xml";
  return MujocoPlant::Create(options);
}

TEST(ContactWatchTest, SeesNothingOfAnArmThatIsFree) {
  const auto plant = MakePlant();
  plant->Reset(kReady);
  ContactWatch watch(*plant);
  // Until the box lies on the table, which is no contact of the arm.
  for (int k = 1; k <= 200; ++k) {
    JointDrive drive;
    drive.tau = plant->GravityTorque(plant->sensors().q);
    plant->Step(drive);
    watch.Look(Time(k * 1ms));
  }
  EXPECT_EQ(watch.looks(), 200u);
  EXPECT_EQ(watch.cycles(), 0u);
  EXPECT_TRUE(watch.Pairs().empty());
}

TEST(ContactWatchTest, NamesWhatTouchesWhenAndHowLong) {
  const auto plant = MakePlant();
  ContactWatch watch(*plant);
  plant->Reset(kReady);
  watch.Look(Time(1ms));
  plant->Reset(kDown);
  watch.Look(Time(2ms));
  watch.Look(Time(3ms));
  EXPECT_EQ(watch.looks(), 3u);
  EXPECT_EQ(watch.cycles(), 2u);
  bool touched_table = false;
  for (const ContactPair& pair : watch.Pairs()) {
    EXPECT_EQ(pair.first, Time(2ms));
    EXPECT_EQ(pair.cycles, 2u) << "points of one pair in one cycle count once";
    EXPECT_EQ(pair.a.substr(0, 6), "panda_") << pair.b;
    touched_table = touched_table || pair.b == "table";
  }
  EXPECT_TRUE(touched_table);
}

TEST(ContactWatchTest, KeepsWhatTouchesAndWhatHasJustEnded) {
  const auto plant = MakePlant();
  ContactWatch watch(*plant);
  plant->Reset(kDown);
  watch.Look(Time(1ms));
  watch.Look(Time(2ms));
  watch.Keep(Time(2ms));
  plant->Reset(kReady);
  watch.Look(Time(3ms));
  watch.Keep(Time(3ms));
  for (int k = 4; k <= 53; ++k) watch.Look(Time(k * 1ms));
  watch.Keep(Time(53ms));
  const std::vector<ContactMoment> moments = watch.Moments();
  ASSERT_EQ(moments.size(), 3u);
  ASSERT_FALSE(moments[0].contacts.empty());
  EXPECT_EQ(moments[1].contacts.size(), moments[0].contacts.size());
  for (const NearContact& one : moments[0].contacts) {
    EXPECT_EQ(one.since, Time(1ms));
    EXPECT_FALSE(one.last) << one.a << " and " << one.b;
    EXPECT_GT(one.p_W[0], 0.2) << "before the robot";
  }
  for (const NearContact& one : moments[1].contacts) {
    EXPECT_EQ(one.last, Time(2ms));
  }
  EXPECT_TRUE(moments[2].contacts.empty()) << "51 looks after its end";
  EXPECT_EQ(moments[2].at, Time(53ms));
}

TEST(ContactWatchTest, AMomentHasWhatAHeldBodyTouches) {
  const test::TemporaryFolder folder;
  const std::filesystem::path scene = folder / "scene.xml";
  // The ready pose has the flange at (0.307, 0, 0.590) m: in the first box and not in the second.
  std::ofstream(scene) << R"(<mujoco><worldbody>
    <geom name="table" type="box" size="0.5 0.5 0.1" pos="0.6 0 0.41"/>
    <body name="box" pos="0.307 0 0.56"><freejoint/><geom type="box" size="0.03 0.03 0.051"/></body>
    <body name="other" pos="0.9 0 0.56"><freejoint/><geom type="box" size="0.03 0.03 0.051"/></body>
  </worldbody></mujoco>)";
  const std::filesystem::path models = TWIN_SOURCE_DIR "/models";
  MujocoPlantOptions options;
  options.urdf = models / "robots" / "panda" / "panda.urdf";
  options.scene = scene;
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  ContactWatch watch(*plant);
  watch.Look(Time(1ms));
  watch.Keep(Time(1ms));
  bool is_told = false;
  const ContactMoment moment = watch.Moments().front();
  for (const NearContact& one : moment.contacts) {
    is_told = is_told || (one.a == "box" && one.b == "table");
    EXPECT_NE(one.a, "other") << "the arm does not touch it";
  }
  EXPECT_TRUE(is_told) << moment.Text();
  for (const ContactPair& pair : watch.Pairs()) EXPECT_NE(pair.a, "box") << "no pair of the arm";
}

TEST(ContactMomentTest, SaysWhoWhereHowStronglyAndSinceWhen) {
  ContactMoment moment;
  EXPECT_EQ(moment.Text(), "none");
  moment.contacts = {{.a = "panda_leftfinger",
                      .b = "floor",
                      .p_W = {0.5, -0.25, 0.0004},
                      .force = 152.6,
                      .since = Time(1204ms)},
                     {.a = "panda_hand", .b = "box", .since = Time(1200ms), .last = Time(1231ms)}};
  EXPECT_EQ(
      moment.Text(),
      "panda_leftfinger and floor at (0.500, -0.250, 0.000) m with up to 153 N, since 1.204 s; "
      "panda_hand and box at (0.000, 0.000, 0.000) m, from 1.200 s until 1.231 s");
}

TEST(ContactWatchTest, LooksInRealTime) {
  const auto plant = MakePlant();
  plant->Reset(kDown);
  ContactWatch watch(*plant);
  const test::RealtimeGuard guard;
  for (int k = 1; k <= 1000; ++k) {
    watch.Look(Time(k * 1ms));
    if (k % 100 == 0) watch.Keep(Time(k * 1ms));
  }
  EXPECT_EQ(guard.allocations(), 0);
  EXPECT_EQ(guard.locks(), 0);
}

}  // namespace
}  // namespace twin::plant::plant_contact_watch_test
