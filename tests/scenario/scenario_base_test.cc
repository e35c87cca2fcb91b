#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/scripts.h"
#include "support/husky.h"
#include "twin/core/error.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_base_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 10ms
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::filesystem::path kModels = std::filesystem::path(TWIN_SOURCE_DIR) / "models";

constexpr std::string_view kMotion = R"(
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 0 s}
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 4 s}
)";

/// @param lines  the scenario's, but for its name and motion.
Scenario With(const std::string& lines) {
  return Parse("name: rolling\n" + lines + std::string(kMotion), "rolling.yaml");
}

std::string ErrorOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string RefusalOf(const std::string& lines) {
  return ErrorOf([&] { (void)With(lines); });
}

TEST(ScenarioBaseTest, ThereIsNoneUnlessAskedFor) {
  const Scenario scenario = With("");
  EXPECT_FALSE(scenario.base.has_value());
  EXPECT_THAT(ToYaml(scenario), ::testing::Not(HasSubstr("base:\n")));
}

TEST(ScenarioBaseTest, ReadsEveryKey) {
  const Scenario scenario = With(R"(base:
  model: husky
  start: {x: 1 m, y: -200 mm, yaw: 90 deg}
  drive:
    - {at: 1 s, for: 500 ms, v: 0.3 m/s}
    - {at: 1.5 s, for: 1 s, v: -0.1 m/s, w: 30 deg/s}
)");
  const BaseSection& base = scenario.base.value();
  EXPECT_EQ(base.model, "husky");
  EXPECT_EQ(base.start.x, 1);
  EXPECT_EQ(base.start.y, -0.2);
  EXPECT_DOUBLE_EQ(base.start.yaw, 1.5707963267948966);
  ASSERT_EQ(base.drive.size(), 2u);
  EXPECT_EQ(base.drive[0], (DriveEvent{1s, 500ms, {0.3, 0}}));
  EXPECT_DOUBLE_EQ(base.drive[1].twist.w, 0.52359877559829882);
}

TEST(ScenarioBaseTest, WhatIsWrittenReadsBack) {
  const Scenario plain = With("base: {}\n");
  EXPECT_EQ(Parse(ToYaml(plain), "s.yaml"), plain);
  const Scenario full = With(R"(base:
  start: {x: 0.1 m, y: 0.7 m, yaw: -1 rad}
  drive: [{at: 1.25 s, for: 500 ms, v: 0.3 m/s, w: -0.1 rad/s}]
)");
  EXPECT_EQ(Parse(ToYaml(full), "s.yaml"), full);
}

TEST(ScenarioBaseTest, RefusesWhatCannotBe) {
  EXPECT_THAT(RefusalOf("base: {}\nplant: {kind: ideal}\n"), HasSubstr("no wheels"));
  EXPECT_THAT(RefusalOf("base: {}\nplant: {base_tilt: {roll: 1 deg}}\n"), HasSubstr("base_tilt"));
  EXPECT_THAT(RefusalOf("base: {}\nbackend: fci\n"), HasSubstr("end of a wire has none"));
  EXPECT_THAT(ErrorOf([] {
                (void)Parse(
                    "name: p\nbase: {}\nrobot: {q_start: {unit: rad, values: [0, -0.8, 0, "
                    "-2.4, 0, 1.6, 0.8]}}\nmotion: {plan: {goal: random}}\n",
                    "p.yaml");
              }),
              HasSubstr("base: a motion is planned for an arm that stands on the world"));
}

TEST(ScenarioBaseTest, RefusesWhatIsOutOfRangeWithItsLine) {
  EXPECT_THAT(RefusalOf("base:\n  start: {x: 2 km}\n"), HasSubstr("rolling.yaml:3"));
  EXPECT_THAT(RefusalOf("base:\n  drive:\n    - {at: 1 s, v: 1 m/s}\n"), HasSubstr("for"));
  EXPECT_THAT(RefusalOf("base:\n  wheels: 4\n"), HasSubstr("wheels"));
}

TEST(ScenarioBaseTest, RefusesDrivesThatOverlap) {
  EXPECT_THAT(RefusalOf("base:\n  drive:\n    - {at: 1 s, for: 2 s, v: 1 m/s}\n"
                        "    - {at: 2 s, for: 1 s, v: 1 m/s}\n"),
              AllOf(HasSubstr("rolling.yaml:5"), HasSubstr("one after the other")));
}

TEST(ScenarioBaseTest, KnowsTheHusky) {
  const BaseData husky = LoadBaseData(kModels, "husky");
  const onboard::BaseConfig expected = twin::test::HuskyConfig();
  EXPECT_EQ(husky.config.wheel_radius, expected.wheel_radius);
  EXPECT_EQ(husky.config.track, expected.track);
  EXPECT_EQ(husky.config.track_factor, expected.track_factor);
  EXPECT_EQ(husky.config.most, expected.most);
  EXPECT_EQ(husky.config.ordinary, expected.ordinary);
  EXPECT_EQ(husky.config.lost, expected.lost);
  EXPECT_EQ(husky.config.emergency, expected.emergency);
  EXPECT_EQ(husky.config.tau_max, expected.tau_max);
  EXPECT_EQ(husky.config.watchdog, expected.watchdog);
  EXPECT_TRUE(std::filesystem::is_regular_file(husky.urdf));
}

TEST(ScenarioBaseTest, NamesTheBasesThereAre) {
  EXPECT_THAT(ErrorOf([] { (void)LoadBaseData(kModels, "panda"); }),
              AllOf(HasSubstr("base.model: \"panda\" is unknown"), HasSubstr("has: husky")));
}

TEST(ScenarioBaseTest, TheHuskyIsNoArm) {
  EXPECT_THAT(ErrorOf([] { (void)LoadRobotData(kModels, "husky", plant::HandKind::kNone); }),
              HasSubstr("\"husky\" is unknown"));
}

TEST(ScenarioBaseTest, TheRobotComesWithIt) {
  const Scenario scenario = With("base: {start: {x: 1 m}}\n");
  const run::RunFiles files{kModels, {}, {}, false};
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kFrankaHand);
  const robot::RobotConfig config = run::MakeRobotConfig(scenario, robot, files);
  ASSERT_TRUE(config.plant.base.has_value());
  EXPECT_EQ(config.plant.base->start, (BasePose{1, 0, 0}));
  EXPECT_EQ(config.base.track, 0.5708);
}

/// Keeps what it is asked for.
class FakeBase final : public backend::MobileBase {
 public:
  void Drive(const BaseTwist& twist) noexcept override { asked.push_back(twist); }
  void EmergencyStop() noexcept override {}
  void Release() noexcept override {}
  [[nodiscard]] BaseState ReadState() const noexcept override { return {}; }
  std::vector<BaseTwist> asked;
};

TEST(DriveScriptTest, AsksForItsDrivesAtTheirTimesAndForZeroBetweenThem) {
  const std::vector<DriveEvent> events{{100ms, 120ms, {0.5, 0}}, {300ms, 50ms, {0, 1}}};
  FakeBase base;
  std::vector<std::string> told;
  run::DriveScript script(events, base,
                          [&told](Time, std::string_view text) { told.emplace_back(text); });
  std::vector<int> times;
  for (Time now{}; now <= Time(360ms); now = script.Attend(now)) {
    times.push_back(static_cast<int>(now.time_since_epoch() / 1ms));
  }
  EXPECT_THAT(times, ElementsAre(0, 50, 100, 150, 200, 220, 270, 300, 350));
  const BaseTwist zero;
  const BaseTwist ahead{0.5, 0};
  EXPECT_THAT(base.asked,
              ElementsAre(zero, zero, ahead, ahead, ahead, zero, zero, (BaseTwist{0, 1}), zero));
  EXPECT_THAT(told, ElementsAre("asked for 0.5 m/s, 0 rad/s for 0.12 s",
                                "asked for 0 m/s, 1 rad/s for 0.05 s"));
}

}  // namespace
}  // namespace twin::scenario::scenario_base_test
