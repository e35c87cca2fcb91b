
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
  EXPECT_THAT(page, HasSubstr("<td>force</td><td>3.0</td>"));
  EXPECT_THAT(page, HasSubstr("<td>grasp</td><td>2</td>"));
  EXPECT_THAT(page, Not(HasSubstr("<video")));
}

TEST(ApplicationPageTest, LeadsWithWhatWasDemandedAndMet) {
  Evaluation evaluation;
  evaluation.DemandAtMost("error", 0.1837, "mm", 5);
  const std::string page = PageOf(Task(), Done(), evaluation, {});
  EXPECT_THAT(page, HasSubstr("The one demand is met: "));
  EXPECT_LT(page.find("The one demand is met: error 0.184 mm (demanded: at most 5 mm)."),
            page.find("Fetch &amp; carry."));
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

TEST(RoundedTextTest, HasNoDigitsBelowWhatTheUnitMeans) {
  EXPECT_EQ(RoundedText(1.07e-10, "mm/s"), "0.00");
  EXPECT_EQ(RoundedText(-1.07e-10, "mm/s"), "0.00");
  EXPECT_EQ(RoundedText(0.18374, "mm"), "0.184");
  EXPECT_EQ(RoundedText(36.1489, "s"), "36.15");
  EXPECT_EQ(RoundedText(1234.56, "mm"), "1235");
  EXPECT_EQ(RoundedText(123.456, "mm"), "123.5");
  EXPECT_EQ(RoundedText(2.5, "furlong"), "2.5");
  EXPECT_EQ(RoundedText(3, ""), "3");
}

TEST(VerdictOfTest, SaysWhatWasDemandedAndMet) {
  Evaluation evaluation;
  EXPECT_EQ(VerdictOf(evaluation), "");
  evaluation.Add("attempts", 1);
  EXPECT_EQ(VerdictOf(evaluation), "") << "nothing is demanded";
  evaluation.DemandAtMost("error", 0.1837, "mm", 5);
  evaluation.DemandAtMost("fall", 4, "ms", 20);
  EXPECT_EQ(VerdictOf(evaluation),
            "All 2 demands are met: error 0.184 mm (demanded: at most 5 mm); fall 4.0 ms "
            "(demanded: at most 20 ms).");
  for (int i = 0; i < 4; ++i) evaluation.DemandAtMost("more", 0, "mm", 1);
  EXPECT_THAT(VerdictOf(evaluation), testing::EndsWith("; and so on, see the results."));
  evaluation.DemandAtMost("speed", 9.81, "mm/s", 1);
  EXPECT_EQ(VerdictOf(evaluation),
            "1 of 7 demands missed: speed 9.81 mm/s (demanded: at most 1 mm/s).");
}

}  // namespace
}  // namespace twin::application::application_page_test
