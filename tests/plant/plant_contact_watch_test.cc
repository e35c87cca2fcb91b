#include "twin/plant/contact_watch.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"
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

TEST(ContactWatchTest, LooksInRealTime) {
  const auto plant = MakePlant();
  plant->Reset(kDown);
  ContactWatch watch(*plant);
  const test::RealtimeGuard guard;
  for (int k = 1; k <= 1000; ++k) watch.Look(Time(k * 1ms));
  EXPECT_EQ(guard.allocations(), 0);
  EXPECT_EQ(guard.locks(), 0);
}

}  // namespace
}  // namespace twin::plant::plant_contact_watch_test
