#include "twin/run/run_history.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/run/result_folder.h"

namespace twin::run::run_history_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::hours;
using ::testing::AllOf;
using ::testing::HasSubstr;

class SetClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const noexcept override { return now; }
  Time now{hours(500'000)};
};

class RunHistoryTest : public ::testing::Test {
 protected:
  RunHistoryTest()
      : folder_(fs::path(::testing::TempDir()) /
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(folder_);
  }
  ~RunHistoryTest() override { fs::remove_all(folder_); }

  void Rehearse(const std::string& failure = {}, double max_speed = 1) const {
    history_.Keep({.hash = "ab",
                   .scenario = "reach",
                   .robot = {},
                   .failure = failure,
                   .max_speed = max_speed,
                   .q_start = JointVector{1, 2, 3, 4, 5, 6, 7}});
  }
  [[nodiscard]] CheckLine Check(double max_speed = 1) const {
    return CheckRehearsal(history_, {.hash = "ab",
                                     .max_speed = max_speed,
                                     .within = hours(24),
                                     .command = "panda-twin run reach.yaml"});
  }

  SetClock clock_;
  const fs::path folder_;
  const RunHistory history_{folder_, clock_};
};

TEST_F(RunHistoryTest, KeepsTheLastRunOfAScenarioOnEachRobot) {
  Rehearse("too fast");
  Rehearse();
  const auto last = history_.Find("ab", "");
  ASSERT_TRUE(last);
  EXPECT_EQ(last->scenario, "reach");
  EXPECT_EQ(last->failure, "");
  EXPECT_EQ(last->q_start, (JointVector{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(last->ended, clock_.now);
  EXPECT_FALSE(history_.Find("ab", "panda:1337")) << "the twin is no robot";
  history_.Keep({.hash = "ab",
                 .scenario = "reach",
                 .robot = "panda:1337",
                 .failure = {},
                 .max_speed = 0.2,
                 .q_start = {},
                 .ended = {}});
  ASSERT_TRUE(history_.Find("ab", "panda:1337"));
  EXPECT_EQ(history_.Find("ab", "panda:1337")->max_speed, 0.2);
  EXPECT_FALSE(history_.Find("ab", "panda_1337"))
      << "the file's name is the same, the robot is not";
}

TEST_F(RunHistoryTest, KeepsTheThousandNewest) {
  fs::create_directories(folder_);
  for (int i = 0; i < 1010; ++i) {
    const fs::path file = folder_ / std::to_string(i);
    std::ofstream(file) << i;
    fs::last_write_time(file, fs::last_write_time(file) - hours(2000 - i));
  }
  Rehearse();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1000);
  EXPECT_TRUE(fs::exists(folder_ / "1009"));
  EXPECT_FALSE(fs::exists(folder_ / "0"));
}

TEST_F(RunHistoryTest, AFolderThatCannotBeMadeIsNamed) {
  MakeFolder(folder_);
  std::ofstream(folder_ / "file") << "x";
  const RunHistory history(folder_ / "file", clock_);
  EXPECT_THROW(
      history.Keep(
          {.hash = "ab", .scenario = {}, .robot = {}, .failure = {}, .q_start = {}, .ended = {}}),
      EnvironmentError);
}

TEST_F(RunHistoryTest, ARehearsalCountsForItsTime) {
  EXPECT_THAT(Check().text, AllOf(HasSubstr("has not run"), HasSubstr("run reach.yaml"),
                                  HasSubstr("--no-rehearsal")));
  Rehearse();
  EXPECT_TRUE(Check().ok) << Check().text;
  EXPECT_THAT(Check().text, HasSubstr("less than a minute ago"));
  clock_.now += std::chrono::minutes(12);
  EXPECT_THAT(Check().text, HasSubstr("12 min ago"));
  clock_.now += hours(24) - std::chrono::minutes(12);
  EXPECT_TRUE(Check().ok) << Check().text;
  clock_.now += std::chrono::nanoseconds(1);
  EXPECT_FALSE(Check().ok);
  EXPECT_THAT(Check().text, HasSubstr("24.0 h ago"));
  clock_.now -= hours(25);
  EXPECT_THAT(Check().text, HasSubstr("calendar"));
}

TEST_F(RunHistoryTest, OnlyASuccessAtTheSpeedToComeCounts) {
  Rehearse("joint 4 stopped");
  EXPECT_FALSE(Check().ok);
  EXPECT_THAT(Check().text, HasSubstr("joint 4 stopped"));
  Rehearse({}, 0.5);
  EXPECT_TRUE(Check(0.5).ok);
  EXPECT_TRUE(Check(0.1).ok);
  EXPECT_FALSE(Check(0.6).ok);
}

TEST_F(RunHistoryTest, ADamagedRecordIsNone) {
  Rehearse();
  std::ofstream(folder_ / "ab.json") << "{\"hash\": \"ab\", ";
  EXPECT_FALSE(Check().ok);
  std::ofstream(folder_ / "ab.json") << "{\"hash\": 7}";
  EXPECT_FALSE(Check().ok);
  for (const char* ended : {"-9223372036854775808", "18446744073709551615", "1e300", "true"}) {
    std::ofstream(folder_ / "ab.json")
        << R"({"hash": "ab", "scenario": "s", "robot": "", "failure": "", "max_speed": 1,)"
        << R"("q_start_rad": null, "ended_ns": )" << ended << "}";
    EXPECT_THAT(Check().text, HasSubstr("has not run")) << ended;
  }
}

TEST(RehearsalHashTest, ChangesWithTheMotionAndNotWithWhereItRuns) {
  const fs::path models = fs::path(TWIN_SOURCE_DIR) / "models";
  const RunFiles files{.models = models, .mesh_package = {}, .cache = {}};
  const scenario::Scenario scenario = scenario::Load(models / "scenarios/smoke.yaml");
  const std::string hash = RehearsalHash(scenario, files);
  scenario::Scenario there = scenario;
  there.backend = "fci";
  there.render.enabled = !there.render.enabled;
  there.record = !there.record;
  EXPECT_EQ(RehearsalHash(there, files), hash);
  scenario::Scenario other = scenario;
  other.motion.waypoints.back().q[0] += 1e-6;
  EXPECT_NE(RehearsalHash(other, files), hash);
  other = scenario;
  other.seed += 1;
  EXPECT_NE(RehearsalHash(other, files), hash);
}

TEST(RehearsalHashTest, ChangesWithTheControllersLibrary) {
  const fs::path library = fs::path(::testing::TempDir()) / "rehearsal_hash.so";
  scenario::Scenario scenario;
  scenario.controller.library = library;
  std::ofstream(library) << "one";
  const std::string one = RehearsalHash(scenario, {});
  std::ofstream(library) << "two";
  EXPECT_NE(RehearsalHash(scenario, {}), one);
  fs::remove(library);
}

TEST(RehearsalHashTest, ChangesWithAFileThatTheSceneIncludes) {
  const twin::test::TemporaryFolder folder;
  scenario::Scenario scenario;
  scenario.scene = folder / "scene.xml";
  std::ofstream(folder / "scene.xml") << R"(<mujoco><include file="floor.xml"/></mujoco>)";
  std::ofstream(folder / "floor.xml") << R"(<mujoco><include file='scene.xml'/></mujoco>)";
  const std::string flat = RehearsalHash(scenario, {});
  std::ofstream(folder / "floor.xml") << "<mujoco/>";
  EXPECT_NE(RehearsalHash(scenario, {}), flat);
}

TEST(RehearsalHashTest, ChangesWithWhateverTheSceneNames) {
  const twin::test::TemporaryFolder folder;
  scenario::Scenario scenario;
  scenario.scene = folder / "scene.xml";
  std::ofstream(folder / "scene.xml") << R"(<mujoco>
  <compiler meshdir="meshes" texturedir = 'pictures'/>
  <asset><mesh file="cup.stl"/><texture type="cube" fileright="right.png"/></asset>
</mujoco>)";
  fs::create_directories(folder / "meshes");
  fs::create_directories(folder / "pictures");
  std::string before = RehearsalHash(scenario, {});
  for (const char* name : {"meshes/cup.stl", "pictures/right.png"}) {
    std::ofstream(folder / name) << "one";
    const std::string one = RehearsalHash(scenario, {});
    EXPECT_NE(one, before) << name;
    std::ofstream(folder / name) << "two";
    before = RehearsalHash(scenario, {});
    EXPECT_NE(before, one) << name;
  }
}

TEST(RehearsalHashTest, LeavesAFolderThatIsNamedAsAFileToTheRun) {
  const twin::test::TemporaryFolder folder;
  scenario::Scenario scenario;
  scenario.scene = folder.path();
  scenario.controller.library = folder.path();
  EXPECT_NO_THROW(static_cast<void>(RehearsalHash(scenario, {})));
}

TEST(CalendarTest, WritesUtc) {
  EXPECT_EQ(FormatUtc(Time()), "1970-01-01T00:00:00Z");
  // 2000-03-01 is 11017 days after 1970-01-01: 30 years, 7 leap days, 31 + 29 days of 2000.
  EXPECT_EQ(FormatUtc(Time(hours(24 * 11017) + std::chrono::seconds(3661))),
            "2000-03-01T01:01:01Z");
  EXPECT_GT(CalendarClock().Now(), Time(hours(24 * 365 * 55))) << "it is later than 2024";
}

}  // namespace
}  // namespace twin::run::run_history_test
