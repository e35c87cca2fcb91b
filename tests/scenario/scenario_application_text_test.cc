// How a scenario names an application in place of a motion.
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_application_text_test {
namespace {

using testing::HasSubstr;

constexpr std::string_view kText = R"(name: task
scene: scenes/floor.xml
robot:
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
tick:
  lambda: 0.01
controller:
  rate: 500 Hz
  cost: 60 us
application:
  type: pick_and_place
  parameters:
    object: {body: box, mass: 100 g}
    heights: [0.1 m, 0.3 m]
)";

/// The message of the error that comes of changing the text in one place.
std::string Spoiled(std::string_view from, std::string_view to) {
  return test::Spoiled(kText, from, to);
}

TEST(ScenarioApplicationTextTest, NamesItAndKeepsItsParameters) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  ASSERT_TRUE(scenario.application.has_value());
  EXPECT_EQ(scenario.application->type, "pick_and_place");
  const control::Parameters& parameters = scenario.application->parameters;
  ASSERT_EQ(parameters.size(), 3U);
  EXPECT_EQ(parameters[1].key, "object.mass");
  EXPECT_EQ(parameters[1].where, "s.yaml:13");
  EXPECT_TRUE(parameters[2].is_list);
  EXPECT_EQ(scenario.places.application.where, "s.yaml:11");
  EXPECT_EQ(scenario.controller.rate_hz, 500);
}

TEST(ScenarioApplicationTextTest, IsWrittenAsItIsRead) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
  EXPECT_EQ(ToYaml(Parse(ToYaml(scenario), "t.yaml")), ToYaml(scenario));
}

TEST(ScenarioApplicationTextTest, MovesAloneAndChoosesItsControllers) {
  EXPECT_THAT(Spoiled("application:", "motion: {plan: {goal: random}}\napplication:"),
              HasSubstr("s.yaml:10: motion: beside an application"));
  EXPECT_THAT(Spoiled("application:", "hand: [{at: 1 s, homing: {}}]\napplication:"),
              HasSubstr("commands the hand itself"));
  EXPECT_THAT(Spoiled("  rate: 500 Hz", "  type: compliance"),
              HasSubstr("s.yaml:8: controller.type: beside an application"));
  EXPECT_THAT(Spoiled("  type: pick_and_place", "  speed: 3"), HasSubstr("s.yaml:11"));
  EXPECT_THAT(Spoiled("  type: pick_and_place", "  type: pick and place"),
              HasSubstr("application.type"));
}

TEST(ScenarioApplicationTextTest, MustSayWhereTheArmRests) {
  EXPECT_THAT(
      Spoiled("  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}", "  hand: none"),
      HasSubstr("robot.q_start"));
}

}  // namespace
}  // namespace twin::scenario::scenario_application_text_test
