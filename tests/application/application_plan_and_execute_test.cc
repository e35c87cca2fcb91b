#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/performance.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::application::application_plan_and_execute_test {
namespace {

using testing::HasSubstr;

scenario::Scenario Shipped() {
  return scenario::Load(test::FileOf("plan_and_execute"));
}

/// The same with other parameters.
scenario::Scenario With(const std::string& parameters) {
  std::string text = scenario::ToYaml(Shipped());
  const std::size_t begin = text.find("  parameters: {", text.find("application:"));
  text.replace(begin, text.find('\n', begin) - begin, "  parameters: {" + parameters + "}");
  return scenario::Parse(text, "task.yaml");
}

TEST(PlanAndExecuteTest, GoesToGoalAfterGoalAndTouchesNothing) {
  const twin::test::TemporaryFolder folder;
  test::Performance performance(With("goals: 2"), folder.path());
  performance.Perform();
  EXPECT_TRUE(performance.succeeded()) << performance.Story();
  ASSERT_EQ(performance.task_result.task.steps.size(), 4U);
  ASSERT_EQ(performance.task_result.plans.size(), 2U);
  EXPECT_NE(performance.task_result.plans[0].q, performance.task_result.plans[1].q);
  EXPECT_GT(performance.task_result.plans[0].until, performance.task_result.plans[0].from);
  ASSERT_NE(performance.Find("cycles with contact of the arm"), nullptr);
  EXPECT_EQ(performance.Find("configurations in collision")->value, 0);
  EXPECT_LT(performance.Find("largest distance of a joint from the plan")->value, 50);
}

TEST(PlanAndExecuteTest, SaysWhichStepFailedAndWhy) {
  test::Performance performance(With("budget: 3"));
  performance.Perform();
  EXPECT_FALSE(performance.succeeded());
  EXPECT_THAT(performance.task_result.task.failure, HasSubstr("step plan failed"));
  EXPECT_EQ(performance.task_result.task.steps.size(), 1U);
}

TEST(PlanAndExecuteTest, ATighterToleranceThanTheArmKeepsIsAFailedStep) {
  test::Performance performance(With(
      "controller: {path_tolerance: {unit: rad, values: [1e-5, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]}}"));
  performance.Perform();
  EXPECT_THAT(performance.task_result.task.failure, HasSubstr("step execute failed"));
}

TEST(PlanAndExecuteTest, RefusesParametersThatAreNotItsOwn) {
  const auto refusal = [](const std::string& parameters) -> std::string {
    try {
      (void)Make(With(parameters));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("speed: 3"), HasSubstr("application.parameters.speed"));
  EXPECT_THAT(refusal("clearance: 1 m"), HasSubstr("application.parameters.clearance"));
  EXPECT_THAT(refusal("goals: 0"), HasSubstr("task.yaml:"));
}

TEST(ApplicationTest, AnUnknownOneIsRefusedByPlaceAndThoseThereAreNamed) {
  scenario::Scenario scenario = scenario::Parse(
      "name: x\nrobot: {q_start: {unit: rad, values: [0, -0.8, 0, -2.3, 0, 1.6, 0.8]}}\n"
      "application: {type: juggle}\n",
      "task.yaml");
  try {
    (void)Make(scenario);
    FAIL() << "it was made";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("task.yaml:3"));
    EXPECT_THAT(error.what(), HasSubstr("plan_and_execute"));
  }
}

TEST(ApplicationTest, RefusesAnArmThatStandsElsewhereWhereItDoesNotMind) {
  scenario::Scenario scenario = scenario::Load(test::FileOf("plan_and_execute"));
  scenario.robot.pose.yaw = 1;
  EXPECT_THAT([&] { (void)Make(scenario); }, testing::ThrowsMessage<InputError>(HasSubstr(
                                                 "robot.pose: the application plan_and_execute")));
}

}  // namespace
}  // namespace twin::application::application_plan_and_execute_test
