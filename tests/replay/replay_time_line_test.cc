#include "twin/replay/time_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/error.h"

namespace twin::replay::replay_time_line_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

Time At(int milliseconds) {
  return Time(std::chrono::milliseconds(milliseconds));
}

/// Scenes at these milliseconds, each with its number as its only position.
render::Snapshots Scenes(const std::vector<int>& milliseconds, int fps) {
  render::Snapshots scenes(fps, 1);
  record::SceneRecord scene;
  scene.positions = 1;
  for (std::size_t i = 0; i < milliseconds.size(); ++i) {
    scene.at = At(milliseconds[i]);
    scene.qpos[0] = static_cast<double>(i);
    scenes.Append(scene);
  }
  return scenes;
}

std::vector<int> Numbers(const render::Snapshots& shown) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    numbers.push_back(static_cast<int>(shown.qpos(i)[0]));
  }
  return numbers;
}

std::string FailureOf(const TimeLine& line) {
  try {
    static_cast<void>(FrameTimes(At(1000), At(3000), line));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no failure";
}

TEST(FrameTimesTest, AreWhatACameraOfThatRateIsDueAt) {
  const auto times = FrameTimes(At(1), At(1001), {.fps = 30});
  ASSERT_THAT(times, SizeIs(31));
  for (std::size_t k = 0; k < times.size(); ++k) {
    EXPECT_EQ(times[k], At(1) + Duration(static_cast<std::int64_t>(k) * 1'000'000'000 / 30));
  }
}

TEST(FrameTimesTest, AreSpreadBySpeed) {
  EXPECT_THAT(FrameTimes(At(0), At(100), {.speed = 0.5, .fps = 20}),
              ElementsAre(At(0), At(25), At(50), At(75), At(100)));
  EXPECT_THAT(FrameTimes(At(0), At(100), {.speed = 2, .fps = 20}), ElementsAre(At(0), At(100)));
}

TEST(FrameTimesTest, BeginAndEndWhereTheyAreTold) {
  EXPECT_THAT(FrameTimes(At(0), At(1000), {.from = At(110), .until = At(200), .fps = 25}),
              ElementsAre(At(110), At(150), At(190)));
}

TEST(FrameTimesTest, OfOneInstantAreOne) {
  EXPECT_THAT(FrameTimes(At(0), At(1000), {.from = At(110), .until = At(110)}),
              ElementsAre(At(110)));
}

TEST(FrameTimesTest, RefusesWhatShowsNothingAndSaysWhatThereIs) {
  EXPECT_THAT(FailureOf({.from = At(3001)}), HasSubstr("the log holds 1 to 3 s"));
  EXPECT_THAT(FailureOf({.until = At(999)}), HasSubstr("the log holds 1 to 3 s"));
  EXPECT_THAT(FailureOf({.from = At(2500), .until = At(2000)}), HasSubstr("before it begins"));
}

TEST(FrameTimesTest, RefusesMoreFramesThanMemoryHolds) {
  EXPECT_NO_THROW(static_cast<void>(FrameTimes(Time(), Time(std::chrono::hours(1)), {})));
  EXPECT_THROW(static_cast<void>(FrameTimes(Time(), Time(std::chrono::hours(100'000)), {})),
               InputError);
}

TEST(FrameTimesTest, RefusesSpeedsAndRatesOutOfRange) {
  for (const double speed : {0.0, 0.001, 101.0, -1.0}) {
    EXPECT_THAT(FailureOf({.speed = speed}), HasSubstr("speed is")) << speed;
  }
  for (const int fps : {0, 241}) EXPECT_THAT(FailureOf({.fps = fps}), HasSubstr("fps is")) << fps;
}

TEST(SnapshotsAtTest, GiveTheFramesOfTheRunsOwnVideo) {
  // The camera was late once: what was due at 80 and at 120 ms was both taken at 125.
  const render::Snapshots scenes = Scenes({0, 40, 125, 125, 160, 200}, 25);
  const auto times = FrameTimes(At(0), At(200), {.fps = 25});
  const render::Snapshots shown = SnapshotsAt(scenes, times, 25);
  ASSERT_EQ(shown.size(), scenes.size());
  for (std::size_t i = 0; i < shown.size(); ++i) EXPECT_EQ(shown.time(i), scenes.time(i));
}

TEST(SnapshotsAtTest, MakeNothingUpBetweenScenes) {
  const std::vector<Time> times{At(0), At(20), At(40), At(60), At(80)};
  EXPECT_THAT(Numbers(SnapshotsAt(Scenes({0, 40, 80}, 25), times, 50)), ElementsAre(0, 1, 1, 2, 2));
}

TEST(SnapshotsAtTest, StayAtTheLastSceneAfterTheEnd) {
  const std::vector<Time> times{At(0), At(40), At(80), At(120)};
  EXPECT_THAT(Numbers(SnapshotsAt(Scenes({0, 40}, 25), times, 25)), ElementsAre(0, 1, 1, 1));
}

TEST(SnapshotsBeforeTest, AreThoseOfTheTimeBeforeAnInstant) {
  const render::Snapshots scenes = Scenes({0, 40, 80, 120, 160}, 25);
  const render::Snapshots before = SnapshotsBefore(scenes, At(120), std::chrono::milliseconds(80));
  ASSERT_EQ(before.size(), 2U);
  EXPECT_EQ(before.time(0), At(40));
  EXPECT_EQ(before.time(1), At(80));
}

}  // namespace
}  // namespace twin::replay::replay_time_line_test
