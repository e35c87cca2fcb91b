// Explanations of runs that no error ended, and of logs that are cut off.
#include <limits>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "report/end_samples.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/report/explanation.h"

namespace twin::report::report_explained_ends_test {
namespace {

using record::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr Violation kJerk{.error = RobotError::kJointMotionGeneratorAccelerationDiscontinuity,
                          .axis = SampleMotion::kJoint,
                          .value = 5000,
                          .limit = 3750};

class ExplainedEndsTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path log() const { return folder_ / "run.mcap"; }

  const TemporaryFolder folder_;
};

TEST_F(ExplainedEndsTest, ASuccessTellsHowCloseItCame) {
  SampleMotion motion(log());
  motion.Serve(1000).Event("motion", "finished");
  const Explanation told = Explain(motion.Finish());
  EXPECT_FALSE(told.aborted);
  EXPECT_EQ(told.page, "");
  // q'' = 1.8 cos(3 t) is largest at the start, where the first difference also takes q''/2.
  EXPECT_THAT(told.text,
              AllOf(HasSubstr("sample: no error; the log ends at 1.000 s"), HasSubstr("joint 2"),
                    HasSubstr("of 2.175 rad/s"), HasSubstr("27.6 %")));
  std::istringstream lines(told.text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

TEST_F(ExplainedEndsTest, AnEarlyEndWithoutAnErrorIsNoSuccess) {
  SampleMotion motion(log());
  motion.Serve(10).Event("motion", "interrupted by the user");
  EXPECT_THAT(Explain(motion.Finish()).text, HasSubstr("ended early: interrupted by the user"));
  SampleMotion stopped(log());
  stopped.Event("motion", "started: joint_position").Serve(10);
  stopped.state().robot_mode = RobotMode::kUserStopped;
  stopped.Serve(20);
  EXPECT_THAT(Explain(stopped.Finish()).text,
              HasSubstr("the user stop was pressed at 0.011 s; the log ends at 0.030 s"));
}

TEST_F(ExplainedEndsTest, AMotionThatTheLogCutsOffHasNoEnd) {
  SampleMotion motion(log());
  motion.Event("motion", "started: joint_position").Serve(10);
  EXPECT_THAT(Explain(motion.Finish()).text,
              HasSubstr("no error of the robot; the log ends in the motion"));
}

TEST_F(ExplainedEndsTest, AUserStopAfterTheMotionEndedNothing) {
  SampleMotion motion(log());
  motion.Event("motion", "started: joint_position").Serve(10).Event("motion", "finished");
  motion.state().robot_mode = RobotMode::kUserStopped;
  motion.Serve(20);
  EXPECT_THAT(Explain(motion.Finish()).text, HasSubstr("no error"));
}

TEST_F(ExplainedEndsTest, ALogWithoutLimitsSaysSo) {
  SampleMotion motion(log());
  motion.Describe({}).Serve(10);
  EXPECT_THAT(Explain(motion.Finish()).text, HasSubstr("does not hold the robot's limits"));
  SampleMotion aborted(log());
  aborted.Describe({}).Serve(10).Abort(kJerk, record::CommandFate::kServed);
  EXPECT_THAT(Explain(aborted.Finish()).page, Not(HasSubstr("How close")));
}

TEST_F(ExplainedEndsTest, AKilledRunIsExplainedWhenItsErrorIsInTheLog) {
  SampleMotion motion(log());
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed);
  motion.Finish();
  std::filesystem::resize_file(log(), std::filesystem::file_size(log()) - 1);
  EXPECT_THAT(Explain(log()).text, HasSubstr("The run was killed later on"));
}

TEST_F(ExplainedEndsTest, AKilledRunWithoutAnErrorIsRefused) {
  SampleMotion motion(log());
  motion.Serve(60);
  motion.Finish();
  std::filesystem::resize_file(log(), std::filesystem::file_size(log()) - 1);
  EXPECT_THROW(static_cast<void>(Explain(log())), InputError);
}

TEST_F(ExplainedEndsTest, ALogWithoutCyclesIsRefused) {
  SampleMotion motion(log());
  motion.Finish();
  EXPECT_THROW(static_cast<void>(Explain(log())), InputError);
  EXPECT_THROW(static_cast<void>(Explain(folder_ / "none.mcap")), InputError);
}

}  // namespace
}  // namespace twin::report::report_explained_ends_test
