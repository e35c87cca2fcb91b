#include "twin/application/application.h"

#include <chrono>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::application::application_task_test {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

/// Steps that note their names, on a clock that goes on by a second with each.
class TaskTest : public testing::Test {
 protected:
  /// @param failures  how many of its first attempts fail.
  TaskStep Step(const std::string& name, int failures = 0, const std::string& after_failure = "",
                int attempts = 1) {
    const auto act = [this, name, left = failures]() mutable -> StepEnd {
      done_.push_back(name);
      now_ += seconds(1);
      if (left-- > 0) return {false, name + " slipped"};
      return {true, ""};
    };
    return {.name = name, .act = act, .after_failure = after_failure, .attempts = attempts};
  }
  TaskReport Run(const std::vector<TaskStep>& steps) {
    return Carry(
        steps, [this] { return now_; }, [this](const StepReport& step) { told_.push_back(step); },
        [this] { return interrupted_; });
  }

  Time now_{};
  bool interrupted_ = false;
  std::vector<std::string> done_;
  std::vector<StepReport> told_;
};

TEST_F(TaskTest, DoesItsStepsInOrder) {
  const TaskReport report = Run({Step("reach"), Step("grasp"), Step("lift")});
  EXPECT_THAT(done_, ElementsAre("reach", "grasp", "lift"));
  EXPECT_EQ(report.failure, "");
  ASSERT_EQ(report.steps.size(), 3U);
  EXPECT_EQ(report.steps[1].begun, Time() + seconds(1));
  EXPECT_EQ(report.steps[1].ended, Time() + seconds(2));
  EXPECT_EQ(told_.size(), 3U);
}

TEST_F(TaskTest, GoesBackAfterAFailureAndCountsTheAttempts) {
  const TaskReport report = Run({Step("reach"), Step("grasp", 1, "reach", 2), Step("lift")});
  EXPECT_THAT(done_, ElementsAre("reach", "grasp", "reach", "grasp", "lift"));
  EXPECT_EQ(report.failure, "");
  EXPECT_EQ(report.steps[1].attempt, 1);
  EXPECT_FALSE(report.steps[1].succeeded);
  EXPECT_EQ(report.steps[3].attempt, 2);
}

TEST_F(TaskTest, FailsWhenItsAttemptsAreUsedUpAndNamesTheStep) {
  const TaskReport report = Run({Step("reach"), Step("grasp", 9, "reach", 3), Step("lift")});
  EXPECT_THAT(done_, ElementsAre("reach", "grasp", "reach", "grasp", "reach", "grasp"));
  EXPECT_EQ(report.failure, "step grasp failed: grasp slipped (attempt 3)");
}

TEST_F(TaskTest, AStepWithoutAWayBackFailsAtOnce) {
  EXPECT_EQ(Run({Step("reach", 1, "", 5), Step("grasp")}).failure,
            "step reach failed: reach slipped");
  EXPECT_THAT(done_, ElementsAre("reach"));
}

TEST_F(TaskTest, ARobotThatIsGoneIsNotTriedAgain) {
  int calls = 0;
  const TaskStep step{.name = "reach",
                      .act = [&calls]() -> StepEnd {
                        ++calls;
                        throw RobotFault("the robot is gone");
                      },
                      .after_failure = "reach",
                      .attempts = 5};
  EXPECT_EQ(Run({step}).failure, "step reach failed: the robot is gone");
  EXPECT_EQ(calls, 1);
}

TEST_F(TaskTest, BeginsNoStepOnceInterrupted) {
  TaskStep first = Step("reach");
  first.act = [this, act = first.act] {
    interrupted_ = true;
    return act();
  };
  EXPECT_EQ(Run({first, Step("grasp")}).failure, "interrupted before step grasp");
  EXPECT_THAT(done_, ElementsAre("reach"));
}

TEST_F(TaskTest, RefusesTasksThatAreNone) {
  const auto refusal = [this](const std::vector<TaskStep>& steps) -> std::string {
    try {
      (void)Run(steps);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal({Step("reach"), Step("reach")}), HasSubstr("reach stands twice"));
  EXPECT_THAT(refusal({Step("reach", 0, "reach", 0)}), HasSubstr("at least 1"));
  EXPECT_THAT(refusal({Step("reach", 0, "grasp", 2), Step("grasp")}),
              HasSubstr("no step at or before it"));
  EXPECT_TRUE(done_.empty());
}

}  // namespace
}  // namespace twin::application::application_task_test
