// How a scenario says who leads the robot.
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::scenario::scenario_operator_test {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr std::string_view kText = R"(name: task
robot:
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
application:
  type: teleoperation
operator:
  device: stick
  parameters: {path: /dev/input/event5}
  settings: {stale_after: 150 ms, arm: {along: {speed: 0.1 m/s}}}
  to_robot_delay: 150 ms
  to_robot_loss: 10 %
)";

/// The message of the error that comes of changing the text in one place.
std::string Spoiled(std::string_view from, std::string_view to) {
  return test::Spoiled(kText, from, to);
}

TEST(ScenarioOperatorTest, NamesTheDeviceAndKeepsItsParameters) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  ASSERT_TRUE(scenario.operator_section.has_value());
  EXPECT_EQ(scenario.operator_section->device, "stick");
  EXPECT_EQ(scenario.operator_section->parameters.front().values.front(), "/dev/input/event5");
}

TEST(ScenarioOperatorTest, SaysHowTheOperatorLeads) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  teleop::TeleoperatorConfig expected;
  expected.stale_after = milliseconds(150);
  expected.along.speed = 0.1;
  EXPECT_EQ(MakeTeleoperator(*scenario.operator_section), expected);
}

TEST(ScenarioOperatorTest, IsWrittenAsItWasRead) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
}

TEST(ScenarioOperatorTest, RefusesASettingThatNobodyKnows) {
  EXPECT_THAT(Spoiled("stale_after", "stale_before"),
              HasSubstr("s.yaml:9: operator.settings.stale_before"));
}

TEST(ScenarioOperatorTest, RefusesASettingOutOfRange) {
  EXPECT_THAT(Spoiled("0.1 m/s", "3 m/s"), HasSubstr("operator.settings.arm.along.speed"));
}

TEST(ScenarioOperatorTest, RefusesAKeyThatNobodyKnows) {
  EXPECT_THAT(Spoiled("to_robot_loss", "to_robot_lost"), HasSubstr("to_robot_lost"));
}

TEST(ScenarioOperatorTest, RefusesParametersThatAreNoMap) {
  const std::string said = Spoiled("{path: /dev/input/event5}", "7");
  EXPECT_THAT(said, HasSubstr("operator.parameters"));
  EXPECT_THAT(said, HasSubstr("must be a map of parameters"));
}

TEST(ScenarioOperatorTest, NeedsADevice) {
  EXPECT_THAT(Spoiled("  device: stick\n", ""), HasSubstr("device"));
}

TEST(ScenarioOperatorTest, LeadsNothingButAnApplication) {
  EXPECT_THAT(Spoiled("application:\n  type: teleoperation\n",
                      "motion:\n  trajectory:\n    unit: deg\n    waypoints:\n"
                      "      - {q: [0, -45, 0, -135, 0, 90, 45]}\n"
                      "      - {q: [0, -45, 0, -135, 0, 90, 40]}\n"),
              HasSubstr("operator: a motion follows its own path"));
}

}  // namespace
}  // namespace twin::scenario::scenario_operator_test
