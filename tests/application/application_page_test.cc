
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/run_recorder.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"

namespace twin::application::application_page_test {
namespace {

using testing::HasSubstr;
using testing::Not;

scenario::Scenario Task() {
  scenario::Scenario scenario;
  scenario.name = "task";
  scenario.description = "Fetch & carry.";
  return scenario;
}

TaskResult Done() {
  TaskResult task_result;
  task_result.task.steps = {{.name = "reach", .succeeded = true}};
  return task_result;
}

TEST(ApplicationPageTest, SucceedsWhenEveryStepIsDoneAndEveryDemandMet) {
  Evaluation evaluation{
      .findings = {{.quantity = "way", .value = 1}, {.quantity = "x", .met = true}}};
  EXPECT_EQ(FailureOf(Done(), evaluation), "");
  evaluation.findings[1] = {
      .quantity = "error", .value = 7.5, .unit = "mm", .demand = "at most 5 mm", .met = false};
  EXPECT_EQ(FailureOf(Done(), evaluation), "error is 7.5 mm; demanded: at most 5 mm");
  TaskResult task_result = Done();
  task_result.task.failure = "step grasp failed: nothing there";
  EXPECT_EQ(FailureOf(task_result, evaluation), "step grasp failed: nothing there");
}

TEST(ApplicationPageTest, TellsStepsFindingsAndFailureAsText) {
  TaskResult task_result = Done();
  task_result.task.steps.push_back(
      {.name = "grasp", .attempt = 2, .succeeded = false, .text = "width < 1 mm"});
  task_result.task.failure = "step grasp failed: width < 1 mm";
  const std::string page = PageOf(
      Task(), task_result, {.findings = {{.quantity = "force", .value = 3, .unit = "N"}}}, {});
  EXPECT_THAT(page, HasSubstr("Fetch &amp; carry."));
  EXPECT_THAT(page, HasSubstr("failed: step grasp failed: width &lt; 1 mm"));
  EXPECT_THAT(page, HasSubstr("<td>force</td><td>3</td>"));
  EXPECT_THAT(page, HasSubstr("<td>grasp</td><td>2</td>"));
  EXPECT_THAT(page, Not(HasSubstr("<video")));
}

TEST(ApplicationPageTest, HasItsPicturesInIt) {
  const test::TemporaryFolder folder;
  // Of 1, 2 and 3 bytes: each rest of three once.
  for (const auto& [name, bytes] : {std::pair{"a.png", "M"}, {"b.png", "Ma"}, {"c.png", "Man"}}) {
    std::ofstream(folder / name) << bytes;
  }
  TaskResult task_result = Done();
  task_result.plans = {{.id = "a", .caption = "Reach"}, {.id = "b", .caption = "Grasp"}};
  PageFacts facts;
  facts.pictures = {{folder / "a.png", folder / "b.png"}, {folder / "c.png", {}}};
  facts.has_video = true;
  facts.lines = {{"lab", "a & b"}};
  const std::string page = PageOf(Task(), task_result, {}, facts);
  EXPECT_THAT(page, HasSubstr("base64,TQ==\""));
  EXPECT_THAT(page, HasSubstr("base64,TWE=\""));
  EXPECT_THAT(page, HasSubstr("base64,TWFu\""));
  EXPECT_THAT(page, HasSubstr("<video"));
  EXPECT_THAT(page, HasSubstr("<td>lab</td><td class=\"word\">a &amp; b</td>"));
  facts.pictures[0].done = folder / "none.png";
  EXPECT_THROW((void)PageOf(Task(), task_result, {}, facts), EnvironmentError);
}

}  // namespace
}  // namespace twin::application::application_page_test
