#include "twin/report/explanation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <string>

#include "record/temporary_folder.h"
#include "report/end_samples.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"

namespace twin::report::report_explanation_test {
namespace {

using record::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr Violation kJerk{.error = RobotError::kJointMotionGeneratorAccelerationDiscontinuity,
                          .axis = SampleMotion::kJoint,
                          .value = 5000,
                          .limit = 3750};

constexpr Violation kLost{
    .error = RobotError::kCommunicationConstraintsViolation, .value = 20, .limit = 20};

/// What the log of a run with --backend fci says about itself.
record::RunInfo Remote() {
  record::RunInfo info;
  info.scenario = "sample";
  info.drive = "remote";
  return info;
}

/// 60 cycles as the workstation's end of a wire records them: every state answered, after `cost`,
/// and no fate known.
void StreamOverWire(SampleMotion& motion, Duration cost) {
  for (int i = 0; i < 60; ++i) {
    record::TickRecord tick;
    tick.action = record::TickAction::kWritten;
    tick.read = Time(static_cast<std::int64_t>(motion.k()) * kCycle);
    tick.written = tick.read + cost;
    motion.AnswerWith(tick).PassBy();
  }
}

/// `text` with every run of white space as one blank: whatever the line breaks.
std::string OneLine(const std::string& text) {
  std::istringstream words(text);
  std::string all;
  for (std::string word; words >> word;) all += (all.empty() ? "" : " ") + word;
  return all;
}

class ExplainTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path log() const { return folder_ / "run.mcap"; }

  const TemporaryFolder folder_;
};

TEST_F(ExplainTest, TellsInWhichMotionOfASessionTheErrorCame) {
  SampleMotion motion(log());
  motion.Event("session", "motion 1: approach").Serve(50);
  motion.Event("session", "motion 2: place").Serve(50).Abort(kJerk, record::CommandFate::kServed);
  motion.Event("session", "motion 3: retreat");
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              AllOf(HasSubstr("in motion 2: place; cycle of state"), Not(HasSubstr("approach")),
                    Not(HasSubstr("retreat"))));
}

TEST_F(ExplainTest, TellsErrorCycleJointValueLimitCauseAndCure) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const Explanation told = Explain(motion.Finish());
  EXPECT_TRUE(told.aborted);
  const ErrorEntry& entry = EntryOf(kJerk);
  for (const std::string& text : {OneLine(told.text), told.page}) {
    EXPECT_THAT(text, AllOf(HasSubstr("sample: aborted at 0.101 s by "
                                      "joint_motion_generator_acceleration_discontinuity"),
                            HasSubstr("joint 2; joint_position motion under joint_impedance"),
                            HasSubstr("cycle of state 1101"),
                            HasSubstr("jerk 5000 rad/s^3; the limit is 3750 rad/s^3"),
                            HasSubstr("exceeded by 33.3 %")));
    EXPECT_THAT(text,
                AllOf(HasSubstr(std::string(entry.meaning)), HasSubstr(std::string(entry.computed)),
                      HasSubstr(std::string(entry.cause)),
                      HasSubstr(CureOf(entry, TimeKeeper::kVirtualClock))));
  }
}

// Uniform noise of a makes up to 8 a / T^3 of jerk.
TEST_F(ExplainTest, NamesNoiseThatTheScenarioInjectsWhereItIsEnough) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const auto path = motion.Finish();
  const auto told = [&path](const Injected& injected) {
    return OneLine(Explain(path, injected).text);
  };
  EXPECT_THAT(
      told({.target_noise = 1e-6}),
      HasSubstr("noise of up to 1e-06 to every target (controller.target_noise), and no "
                "reference generator smooths it: the noise alone makes up to 8e+03 rad/s^3"));
  for (const Injected& injected : {Injected{}, Injected{.target_noise = 4e-7},
                                   Injected{.target_noise = 1e-6, .is_smoothed = true}}) {
    EXPECT_THAT(told(injected), Not(HasSubstr("injected")));
  }
}

TEST_F(ExplainTest, PageNeedsNoOtherFileAndNoNetwork) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const std::string page = Explain(motion.Finish()).page;
  EXPECT_EQ(page.find("<!DOCTYPE html>"), 0U);
  EXPECT_THAT(page, AllOf(HasSubstr("<svg"), HasSubstr("</html>"), Not(HasSubstr("<?xml"))));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("src=")), Not(HasSubstr("<link")),
                          Not(HasSubstr("@import")), Not(HasSubstr("href=\"http")),
                          Not(HasSubstr("href='http")), Not(HasSubstr("<script"))));
}

TEST_F(ExplainTest, SameLogGivesTheSameBytes) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  motion.Finish();
  const Explanation first = Explain(log());
  const Explanation second = Explain(log());
  EXPECT_EQ(first.text, second.text);
  EXPECT_EQ(first.page, second.page);
}

TEST_F(ExplainTest, LinesFitATerminal) {
  SampleMotion motion(log());
  motion.Serve(30).Lose(7, true).Abort(kJerk, record::CommandFate::kServed);
  std::istringstream lines(Explain(motion.Finish()).text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

TEST_F(ExplainTest, ShowsTheLastFiftyCyclesWhereTheRunHasThem) {
  SampleMotion motion(log());
  motion.Serve(200).Abort(kJerk, record::CommandFate::kServed);
  const std::string page = Explain(motion.Finish()).page;
  EXPECT_THAT(page, AllOf(HasSubstr("The last 50 cycles"), HasSubstr("<td>1152</td>"),
                          HasSubstr("<td>1201</td>"), Not(HasSubstr("<td>1150</td>"))));
}

TEST_F(ExplainTest, ExplainsARunThatAbortsInItsFirstCycles) {
  for (const int before : {0, 1, 2}) {
    SampleMotion motion(log());
    motion.Serve(before).Abort(kJerk, record::CommandFate::kNone);
    EXPECT_TRUE(Explain(motion.Finish()).aborted) << before;
  }
}

TEST_F(ExplainTest, NamesWhatElseWasRaisedInTheCycle) {
  SampleMotion motion(log());
  motion.Serve(60);
  motion.state().errors.set(static_cast<std::size_t>(RobotError::kTauJRangeViolation));
  motion.Abort(kJerk, record::CommandFate::kServed);
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              HasSubstr("In the same cycle: tau_J_range_violation."));
}

TEST_F(ExplainTest, ExplainsAnErrorWhoseValueTheLogDoesNotHold) {
  SampleMotion motion(log());
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed, false);
  const Explanation told = Explain(motion.Finish());
  EXPECT_THAT(OneLine(told.text),
              AllOf(HasSubstr("aborted at 0.061 s by joint_motion_generator_acceleration"),
                    HasSubstr("does not tell which value"), Not(HasSubstr("rad/s^3;"))));
}

TEST_F(ExplainTest, ExplainsTheFirstOfSeveral) {
  SampleMotion motion(log());
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed).Recover().Serve(10);
  motion.Abort({.error = RobotError::kJointReflex, .axis = 0, .value = 30, .limit = 20},
               record::CommandFate::kNone);
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              AllOf(HasSubstr("aborted at 0.061 s"), HasSubstr("ended 2 motions of this log"),
                    Not(HasSubstr("joint_reflex"))));
}

TEST_F(ExplainTest, AMissingFirstCommandIsNotALoss) {
  SampleMotion motion(log());
  motion.Abort({.error = RobotError::kCommunicationConstraintsViolation,
                .axis = 0,
                .value = 1000,
                .limit = 1000},
               record::CommandFate::kNone);
  EXPECT_THAT(
      OneLine(Explain(motion.Finish()).text),
      AllOf(HasSubstr("The motion's first command did not come"), Not(HasSubstr("in a row"))));
}

TEST_F(ExplainTest, ARunInRealTimeIsToldWhatHelpsThere) {
  SampleMotion motion(log());
  record::RunInfo info;
  info.scenario = "sample";
  info.drive = "realtime";
  motion.Describe(info).Serve(30).Lose(20, false);
  motion.SetLost(20);
  motion.Abort({.error = RobotError::kCommunicationConstraintsViolation, .value = 20, .limit = 20},
               record::CommandFate::kHeld);
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              AllOf(HasSubstr("panda-twin check"), HasSubstr("it may be at most 19")));
}

TEST_F(ExplainTest, AtTheEndOfAWireTheFateOfCommandsIsNotKnown) {
  SampleMotion motion(log());
  motion.Describe(Remote());
  StreamOverWire(motion, Duration(20'000));
  const Explanation told = Explain(motion.Abort(kLost, record::CommandFate::kNone, false).Finish());
  for (const std::string& text : {OneLine(told.text), told.page}) {
    EXPECT_THAT(
        text,
        AllOf(HasSubstr("not known at this end of the wire"), HasSubstr("panda-twin serve --log"),
              HasSubstr("neither joint nor value nor limit"), HasSubstr("panda-twin check")));
    EXPECT_THAT(text, AllOf(Not(HasSubstr("0 cycles served")), Not(HasSubstr("none was due")),
                            Not(HasSubstr("lost before")), Not(HasSubstr("had its command"))));
  }
  EXPECT_THAT(told.page, AllOf(HasSubstr("not known</td>"), Not(HasSubstr("none due"))));
}

TEST_F(ExplainTest, OnTheRobotsTimeNoThreadIsBlamed) {
  SampleMotion motion(log());
  motion.Describe(Remote());
  StreamOverWire(motion, Duration::zero());
  EXPECT_THAT(
      OneLine(Explain(motion.Abort(kLost, record::CommandFate::kNone, false).Finish()).text),
      AllOf(HasSubstr("not known at this end of the wire"), Not(HasSubstr("panda-twin check"))));
}

TEST_F(ExplainTest, ASuccessOverAWireDoesNotClaimThatNothingWasLost) {
  SampleMotion motion(log());
  motion.Describe(Remote());
  StreamOverWire(motion, Duration(20'000));
  motion.Event("motion", "finished");
  EXPECT_THAT(Explain(motion.Finish()).text,
              AllOf(HasSubstr("not known at this end"), Not(HasSubstr("lost in a row"))));
}

TEST_F(ExplainTest, AtTheRobotsEndOfAWireItIsNotKnownWhatTheClientDid) {
  SampleMotion motion(log());
  motion.Lose(20, false);
  EXPECT_THAT(OneLine(Explain(motion.Abort(kLost, record::CommandFate::kHeld).Finish()).text),
              AllOf(HasSubstr("0 cycles served, 21 held"), HasSubstr("is not in this log"),
                    Not(HasSubstr("did not run"))));
}

TEST_F(ExplainTest, OverAWireWithoutAMotionNoCommandWasDue) {
  SampleMotion motion(log());
  motion.Describe(Remote());
  motion.state().motion_generator_mode = MotionGeneratorMode::kIdle;
  for (int i = 0; i < 60; ++i) motion.PassBy();
  EXPECT_THAT(
      OneLine(Explain(motion.Abort(kLost, record::CommandFate::kNone, false).Finish()).text),
      AllOf(HasSubstr("none was due"), Not(HasSubstr("this end of the wire"))));
}

TEST_F(ExplainTest, PageShowsWhatTheRunIsCalledAndNotWhatItMeansToABrowser) {
  SampleMotion motion(log());
  record::RunInfo info;
  info.scenario = "a<b> & \"c\"";
  motion.Describe(info).Serve(60).Abort(kJerk, record::CommandFate::kServed);
  const std::string page = Explain(motion.Finish()).page;
  EXPECT_THAT(page, AllOf(HasSubstr("a&lt;b&gt; &amp; &quot;c&quot;"), Not(HasSubstr("a<b>"))));
}

TEST_F(ExplainTest, NumbersThatAreNoneAreNoReasonToFail) {
  for (const double odd :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    SampleMotion motion(log());
    motion.Serve(60);
    motion.state().q[SampleMotion::kJoint] = motion.state().ddq_d[SampleMotion::kJoint] = odd;
    Violation violation = kJerk;
    violation.value = odd;
    motion.Abort(violation, record::CommandFate::kServed);
    EXPECT_TRUE(Explain(motion.Finish()).aborted) << odd;
  }
}

TEST_F(ExplainTest, ASuccessTellsHowCloseItCame) {
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

TEST_F(ExplainTest, AnEarlyEndWithoutAnErrorIsNoSuccess) {
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

TEST_F(ExplainTest, AUserStopAfterTheMotionEndedNothing) {
  SampleMotion motion(log());
  motion.Event("motion", "started: joint_position").Serve(10).Event("motion", "finished");
  motion.state().robot_mode = RobotMode::kUserStopped;
  motion.Serve(20);
  EXPECT_THAT(Explain(motion.Finish()).text, HasSubstr("no error"));
}

TEST_F(ExplainTest, ALogWithoutLimitsSaysSo) {
  SampleMotion motion(log());
  motion.Describe({}).Serve(10);
  EXPECT_THAT(Explain(motion.Finish()).text, HasSubstr("does not hold the robot's limits"));
  SampleMotion aborted(log());
  aborted.Describe({}).Serve(10).Abort(kJerk, record::CommandFate::kServed);
  EXPECT_THAT(Explain(aborted.Finish()).page, Not(HasSubstr("How close")));
}

TEST_F(ExplainTest, AKilledRunIsExplainedWhenItsErrorIsInTheLog) {
  SampleMotion motion(log());
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed);
  motion.Finish();
  std::filesystem::resize_file(log(), std::filesystem::file_size(log()) - 1);
  EXPECT_THAT(Explain(log()).text, HasSubstr("The run was killed later on"));
}

TEST_F(ExplainTest, AKilledRunWithoutAnErrorIsRefused) {
  SampleMotion motion(log());
  motion.Serve(60);
  motion.Finish();
  std::filesystem::resize_file(log(), std::filesystem::file_size(log()) - 1);
  EXPECT_THROW(static_cast<void>(Explain(log())), InputError);
}

TEST_F(ExplainTest, ALogWithoutCyclesIsRefused) {
  SampleMotion motion(log());
  motion.Finish();
  EXPECT_THROW(static_cast<void>(Explain(log())), InputError);
  EXPECT_THROW(static_cast<void>(Explain(folder_ / "none.mcap")), InputError);
}

}  // namespace
}  // namespace twin::report::report_explanation_test
