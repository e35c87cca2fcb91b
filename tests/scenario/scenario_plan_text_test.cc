// How a scenario says that its motion is to be planned.
#include <chrono>
#include <numbers>
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/run/remote.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_plan_text_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kPoseGoal =
    "{pose: {position: [0.4 m, 0.3 m, 500 mm], rpy: [180 deg, 0 deg, 45 deg]}}";

/// The message with which the example, changed in one place, is refused.
std::string Spoiled(std::string_view from, std::string_view to) {
  return test::Spoiled(test::PlanText(), from, to);
}

TEST(ScenarioPlanTextTest, ReadsEveryKey) {
  const MotionSection motion = Parse(test::PlanText(), "s.yaml").motion;
  ASSERT_TRUE(motion.plan.has_value());
  const PlanSection& plan = *motion.plan;
  ASSERT_TRUE(std::holds_alternative<FramePose>(plan.goal));
  EXPECT_EQ(std::get<FramePose>(plan.goal).position, (Vector3{0.4, 0.3, 0.5}));
  EXPECT_DOUBLE_EQ(std::get<FramePose>(plan.goal).rpy[0], std::numbers::pi);
  EXPECT_EQ(plan.seed, 7u);
  EXPECT_EQ(plan.budget, 20'000u);
  EXPECT_EQ(plan.clearance, 0.02);
  EXPECT_EQ(plan.stretch, 1.5);
  EXPECT_EQ(plan.where, "s.yaml:7");
  EXPECT_EQ(motion.timing.velocity_scale, 0.4);
  EXPECT_EQ(motion.timing.acceleration_scale, 0.15);
  EXPECT_EQ(motion.timing.jerk_scale, 0.05);
  EXPECT_TRUE(motion.waypoints.empty());
}

TEST(ScenarioPlanTextTest, SurvivesTheRoundTripWithEachGoal) {
  for (const char* goal :
       {"random", "{q: {unit: deg, values: [10, -40, 0, -130, 0, 90, 45]}}", kPoseGoal}) {
    const Scenario scenario = Parse(test::Replaced(test::PlanText(), kPoseGoal, goal), "s.yaml");
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario) << goal;
  }
}

TEST(ScenarioPlanTextTest, TellsPlansApart) {
  const Scenario scenario = Parse(test::PlanText(), "s.yaml");
  for (const auto& [from, to] : {std::pair{kPoseGoal, "random"},
                                 {"    seed: 7\n", ""},
                                 {"20000", "20001"},
                                 {"20 mm", "21 mm"},
                                 {"1.5", "1.25"}}) {
    EXPECT_FALSE(Parse(test::Replaced(test::PlanText(), from, to), "s.yaml") == scenario) << to;
  }
}

TEST(ScenarioPlanTextTest, RefusesWhatMakesNoSense) {
  EXPECT_THAT(Spoiled(kPoseGoal, "nearby"), AllOf(StartsWith("s.yaml:8: "), HasSubstr("random")));
  EXPECT_THAT(Spoiled("rpy: [180 deg, 0 deg, 45 deg]", ""), HasSubstr("rpy"));
  EXPECT_THAT(Spoiled("20 mm", "0.5 m"), StartsWith("s.yaml:11: "));
  EXPECT_THAT(Spoiled("budget: 20000", "budget: 0"), StartsWith("s.yaml:10: "));
  EXPECT_THAT(Spoiled("stretch: 1.5", "stretch: 0.5"), StartsWith("s.yaml:12: "));
  EXPECT_THAT(Spoiled("stretch: 1.5", "duration: 4 s"), HasSubstr("duration"));
  EXPECT_THAT(Spoiled("  plan:", "  trajectory: t.yaml\n  plan:"), HasSubstr("one of the two"));
  EXPECT_THAT(
      Spoiled("  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}", "  hand: none"),
      HasSubstr("robot.q_start"));
  EXPECT_THAT(Spoiled("name: plan", "name: plan\nhand: [{at: 1 s, homing: {}}]"),
              HasSubstr("the hand"));
}

TEST(ScenarioPlanTextTest, IsSlowedDownByItsStretch) {
  Scenario scenario = Parse(test::PlanText(), "s.yaml");
  run::SlowDown(scenario, RobotData(), 0.5);
  EXPECT_EQ(scenario.motion.plan->stretch, 3);
}

TEST(ScenarioPlanTextTest, NeedsItsSceneOnARobotToo) {
  const Scenario scenario = Parse(test::PlanText(), "s.yaml");
  EXPECT_TRUE(run::WithoutEffectThere(scenario).empty());
}

}  // namespace
}  // namespace twin::scenario::scenario_plan_text_test
