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

TEST_F(ExplainTest, NamesATorqueThatWasCommandedOnAndOn) {
  const auto torques = [this](int same) {
    SampleMotion motion(log());
    motion.state().controller_mode = ControllerMode::kExternalController;
    for (int i = 0; i < 40; ++i) {
      motion.state().tau_J_d[0] = i < 40 - same ? 0.1 * i : 7;
      motion.Serve(1);
    }
    motion.Abort({RobotError::kJointVelocityViolation, 6, 2.9, 2.871},
                 record::CommandFate::kServed);
    return OneLine(Explain(motion.Finish()).text);
  };
  EXPECT_THAT(torques(20), HasSubstr("The same torque was commanded for 20 cycles in a row"));
  EXPECT_THAT(torques(5), Not(HasSubstr("same torque")));
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
TEST_F(ExplainTest, HasTheErrorInFieldsToo) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const std::optional<ExplainedError> error = Explain(motion.Finish()).error;
  ASSERT_TRUE(error);
  EXPECT_EQ(error->violation.error, kJerk.error);
  EXPECT_TRUE(error->has_value);
  EXPECT_EQ(error->violation.axis, kJerk.axis);
  EXPECT_EQ(error->violation.value, kJerk.value);
  EXPECT_EQ(error->violation.limit, kJerk.limit);
  EXPECT_EQ(error->cycle, motion.state().message_id);
  EXPECT_EQ(error->motion, 1U);
}

TEST_F(ExplainTest, DrawsNoPageForTheTextAlone) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const std::filesystem::path file = motion.Finish();
  const Explanation text = Explain(file, std::nullopt, std::nullopt, ExplanationParts::kText);
  EXPECT_EQ(text.page, "");
  EXPECT_EQ(text.text, Explain(file).text);
}

TEST_F(ExplainTest, NamesNoiseThatTheScenarioInjectsWhereItIsEnough) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed);
  const auto path = motion.Finish();
  const auto told = [&path](const ScenarioFacts& facts) {
    return OneLine(Explain(path, facts).text);
  };
  EXPECT_THAT(
      told({.target_noise = 1e-6}),
      HasSubstr("noise of up to 1e-06 to every target (controller.target_noise), and no "
                "reference generator smooths it: the noise alone makes up to 8e+03 rad/s^3"));
  for (const ScenarioFacts& facts : {ScenarioFacts{}, ScenarioFacts{.target_noise = 4e-7},
                                     ScenarioFacts{.target_noise = 1e-6, .has_generator = true}}) {
    EXPECT_THAT(told(facts), Not(HasSubstr("injected")));
  }
}

TEST_F(ExplainTest, BlamesNoNoiseWhereTheScenarioAddsNone) {
  SampleMotion motion(log());
  motion.Serve(100).Abort({.error = RobotError::kJointMotionGeneratorAccelerationDiscontinuity,
                           .axis = SampleMotion::kJoint,
                           .value = -5000,
                           .limit = -3750},
                          record::CommandFate::kServed);
  EXPECT_THAT(OneLine(Explain(motion.Finish(), ScenarioFacts{}).text), Not(HasSubstr("injected")));
}

constexpr Violation kReflex{
    .error = RobotError::kCartesianReflex, .axis = 0, .value = 30, .limit = 20};

/// 60 commands that a viability filter changed, while the targets are `away`
/// rad ahead.
void KeepBack(SampleMotion& motion, double away) {
  for (int i = 0; i < 60; ++i) {
    record::TickRecord tick;
    tick.action = record::TickAction::kWritten;
    tick.margin = 0.1;
    tick.kept_back = 1;
    tick.q_ext = motion.state().q;
    tick.q_ext[3] += away;
    motion.AnswerWith(tick).PassBy();
  }
}

TEST_F(ExplainTest, NamesWhatLedTheArmAwayFromItsPlanForEveryError) {
  SampleMotion motion(log());
  KeepBack(motion, 0.5);
  motion.Abort(kReflex, record::CommandFate::kServed);
  const std::string told =
      OneLine(Explain(motion.Finish(), ScenarioFacts{.target_noise = 1e-3}).text);
  EXPECT_THAT(told, AllOf(HasSubstr("kept back the viability filter changed 50 of these 50"),
                          HasSubstr("deviation joint 4 was 0.5 rad away from its target"),
                          HasSubstr("injected the scenario adds noise of up to 0.001"),
                          HasSubstr("what to do first see that the arm follows its plan: take the "
                                    "noise out (controller.target_noise); leave tick.generator")));
}

TEST_F(ExplainTest, NamesWhatHinderedAMotionThatEndedEarlyWithoutAnError) {
  SampleMotion motion(log());
  KeepBack(motion, 0.5);
  motion.Event("motion", "the motion did not end within 22 s of run time").Finish();
  EXPECT_THAT(OneLine(Explain(log(), ScenarioFacts{.target_noise = 1e-3}).text),
              AllOf(HasSubstr("kept back the viability filter changed 60 of 60 commands"),
                    HasSubstr("injected the scenario adds noise of up to 0.001")));
}

TEST_F(ExplainTest, TellsNoSmallDeviation) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kReflex, record::CommandFate::kServed);
  EXPECT_THAT(OneLine(Explain(motion.Finish(), ScenarioFacts{.target_noise = 1e-7}).text),
              AllOf(Not(HasSubstr("kept back")), Not(HasSubstr("deviation")),
                    Not(HasSubstr("injected")), Not(HasSubstr("first see"))));
}

TEST_F(ExplainTest, NamesAForceThatTheScenarioScripts) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kReflex, record::CommandFate::kServed);
  motion.Event("contact", "none").Finish();
  const auto told = [this](double begin, std::optional<std::uint64_t> number) {
    const ScriptedForce push{"pushes panda_hand with 30 N", begin, begin + 0.3, number};
    return OneLine(Explain(log(), ScenarioFacts{.forces = {push}}).text);
  };
  EXPECT_THAT(told(0.05, {}), HasSubstr("touched nothing in the 50 cycles before. The scenario "
                                        "pushes panda_hand with 30 N from 0.050 s to 0.350 s"));
  EXPECT_THAT(told(0.05, 1), HasSubstr("0.350 s of the motion (perturbations)"));
  EXPECT_THAT(told(0.05, 2), Not(HasSubstr("pushes"))) << "another motion";
  EXPECT_THAT(told(0.2, {}), Not(HasSubstr("pushes"))) << "later";
}

TEST_F(ExplainTest, HasTheLimitThatAServedRobotsGuardNames) {
  SampleMotion motion(log());
  motion.Serve(100).Abort({.error = RobotError::kCartesianPositionLimitsViolation,
                           .axis = 0,
                           .value = 0.5,
                           .limit = 0.4},
                          record::CommandFate::kServed);
  motion.Event("motion",
               "aborted by reflex: some value. Guard: limit "
               "\"cell\": the hand reaches x");
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              HasSubstr("value limit \"cell\": the hand reaches x."));
}

TEST_F(ExplainTest, SaysHowAMotionWithoutAnErrorEnded) {
  SampleMotion motion(log());
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed).Rest(5).Recover().Serve(10).Rest(5);
  motion.Event("motion", "stopped: it was not answered for too long").Finish();
  try {
    static_cast<void>(Explain(log(), std::nullopt, 2));
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("motion 2 ended otherwise: stopped: it was not answered"));
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

/// Three motions; errors end the first and the third.
std::filesystem::path AbortTwice(const std::filesystem::path& log) {
  SampleMotion motion(log);
  motion.Serve(60).Abort(kJerk, record::CommandFate::kServed).Rest(5).Recover().Serve(10);
  motion.Rest(5).Recover().Serve(70);
  motion.Abort({.error = RobotError::kJointReflex, .axis = 0, .value = 30, .limit = 20},
               record::CommandFate::kNone);
  return motion.Finish();
}

TEST_F(ExplainTest, ExplainsTheFirstOfSeveralAndSaysWhichOthersThereAre) {
  EXPECT_THAT(OneLine(Explain(AbortTwice(log())).text),
              AllOf(HasSubstr("aborted at 0.061 s"), HasSubstr("2 errors, in motions 1 and 3"),
                    HasSubstr("the page has all"), Not(HasSubstr("joint_reflex"))));
}

TEST_F(ExplainTest, ExplainsTheMotionThatIsAskedFor) {
  const Explanation told = Explain(AbortTwice(log()), std::nullopt, 3);
  EXPECT_THAT(OneLine(told.text),
              AllOf(HasSubstr("aborted at 0.152 s by joint_reflex"),
                    HasSubstr("this is about motion 3"), HasSubstr("joint 1; joint_position"),
                    HasSubstr("49 cycles served"), Not(HasSubstr("aborted at 0.061 s"))));
  try {
    static_cast<void>(Explain(log(), std::nullopt, 2));
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no error ended motion 2 of sample; errors ended motion "
                                        "1 and 3"));
  }
}

TEST_F(ExplainTest, ThePageHasEveryError) {
  const std::string page = Explain(AbortTwice(log())).page;
  EXPECT_THAT(page, AllOf(HasSubstr("<h1>sample: 2 errors</h1>"),
                          HasSubstr("<h2 id=\"end1\">sample: aborted at 0.061 s"),
                          HasSubstr("<h2 id=\"end2\">sample: aborted at 0.152 s by joint_reflex"),
                          HasSubstr("<a href=\"#end2\">")));
  std::size_t drawn = 0;
  for (std::size_t at = page.find("<svg"); at != std::string::npos;
       at = page.find("<svg", at + 1)) {
    ++drawn;
  }
  EXPECT_EQ(drawn, 2U);
}

TEST_F(ExplainTest, APageOfManyErrorsHasTheFirstAndTheOneAskedFor) {
  SampleMotion motion(log());
  for (int i = 0; i < 23; ++i) {
    motion.Serve(5).Abort(kJerk, record::CommandFate::kServed).Rest(3).Recover();
  }
  motion.Finish();
  const Explanation told = Explain(log(), std::nullopt, 22);
  EXPECT_THAT(told.page,
              AllOf(HasSubstr("<h1>sample: 23 errors</h1>"), HasSubstr("id=\"end21\""),
                    Not(HasSubstr("id=\"end22\"")), HasSubstr("These are 21 of 23 errors"),
                    HasSubstr("sample: aborted at 0.195 s")));
  EXPECT_THAT(OneLine(told.text), HasSubstr("the page has 21 of them"));
}

TEST_F(ExplainTest, NamesAJointAtItsEndStopAndHowFarItIsBeyond) {
  SampleMotion motion(log());
  motion.Serve(60);
  motion.state().q[3] = -0.0684;
  motion.Abort({.error = RobotError::kCartesianReflex, .axis = 2, .value = 970, .limit = 100},
               record::CommandFate::kServed);
  EXPECT_THAT(OneLine(Explain(motion.Finish()).text),
              AllOf(HasSubstr("end stop joint 4 is at its upper end stop: q = -0.0684 rad, 1.4 "
                              "mrad beyond -0.0698 rad"),
                    HasSubstr("takes that for an external force")));
}

TEST_F(ExplainTest, AJointNearItsEndIsNotAtItsStop) {
  SampleMotion motion(log());
  motion.Serve(60);
  motion.state().q[0] = -2.8973 + 2e-3;
  EXPECT_THAT(OneLine(Explain(motion.Abort(kJerk, record::CommandFate::kServed).Finish()).text),
              Not(HasSubstr("end stop")));
}

TEST_F(ExplainTest, NamesWhatTheSimulatedArmTouched) {
  constexpr Violation kReflex{
      .error = RobotError::kJointReflex, .axis = 0, .value = 30, .limit = 20};
  const auto told = [&](const Violation& violation, std::string_view contacts) {
    SampleMotion motion(log());
    motion.Serve(60).Abort(violation, record::CommandFate::kServed).Event("contact", contacts);
    return OneLine(Explain(motion.Finish()).text);
  };
  EXPECT_THAT(told(kReflex, "panda_hand and table at (0.500, 0.000, 0.200) m with 90 N"),
              HasSubstr("touching panda_hand and table at (0.500, 0.000, 0.200) m with 90 N."));
  EXPECT_THAT(told(kReflex, "none"), HasSubstr("touched nothing in the 50 cycles before"));
  EXPECT_THAT(told(kJerk, "none"), Not(HasSubstr("touch"))) << "no error that contacts cause";
}

TEST_F(ExplainTest, TellsLostFromLateCommandsWhereTheLinkIsKnown) {
  using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 980us
  SampleMotion motion(log());
  motion.Serve(60).Lose(5, true).Lose(2, false);
  motion.SetLost(8);
  motion.Abort(kLost, record::CommandFate::kHeld).Finish();
  LinkFacts link{.seed = 1, .state = {}, .command = {}, .d_INT = 100us};
  // Answers are written 0.12 ms after the cycle and due 0.9 ms after it. Ids are 1000 + k.
  link.command.loss = faults::LossModel(faults::ScriptedLoss{{{.first = 1060, .count = 3}}});
  link.command.delay = faults::DelayModel(faults::ConstantDelay{980us});
  link.state.loss = faults::LossModel(faults::ScriptedLoss{{{.first = 1065, .count = 1}}});
  const Explanation told = Explain(log(), ScenarioFacts{.link = link});
  EXPECT_THAT(OneLine(told.text),
              AllOf(HasSubstr("1 because the link lost the state before it"),
                    HasSubstr("2 because the workstation did not see the state"),
                    HasSubstr("3 because the link lost the command"),
                    HasSubstr("2 because the command came too late, by up to 0.2 ms")));
  for (const char* word : {"held: lost<", "held: 0.2 ms late<", "held: state lost<"}) {
    EXPECT_THAT(told.page, HasSubstr(word));
  }
}

TEST_F(ExplainTest, AdvisesOnlyWhatIsNotSet) {
  SampleMotion motion(log());
  motion.Serve(100).Abort(kJerk, record::CommandFate::kServed).Finish();
  const auto told = [&](const ScenarioFacts& facts) { return OneLine(Explain(log(), facts).text); };
  EXPECT_THAT(told({}), AllOf(HasSubstr("leave tick.generator and tick.viability out"),
                              HasSubstr("tick.limiter: true")));
  EXPECT_THAT(told({.has_limiter = true}), Not(HasSubstr("tick.limiter")));
  EXPECT_THAT(told({.has_generator = true}), HasSubstr("tick.viability: 19 behind"));
  EXPECT_THAT(told({.has_generator = true, .has_default_generator = true}),
              AllOf(HasSubstr("leave tick.viability out"), Not(HasSubstr("tick.generator"))));
  EXPECT_THAT(told({.has_viability = true}),
              AllOf(HasSubstr("leave tick.generator out"), Not(HasSubstr("tick.viability"))));
  EXPECT_THAT(told({.has_generator = true, .has_default_generator = true, .has_viability = true}),
              AllOf(HasSubstr("what to do move more gently."), Not(HasSubstr("tick."))));
}

TEST(RemedyInTest, LeavesOutALimiterThatIsOn) {
  constexpr Violation kStep{.error = RobotError::kControllerTorqueDiscontinuity, .axis = 0};
  const auto told = [&kStep](bool has_limiter) {
    return RemedyIn({.has_limiter = has_limiter}, kStep, TimeKeeper::kVirtualClock, false);
  };
  EXPECT_THAT(told(false), HasSubstr("tick.limiter: true"));
  EXPECT_THAT(told(true), Not(HasSubstr("limit")));
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
              AllOf(HasSubstr("panda-twin check"), HasSubstr("20 end a motion")));
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
                    Not(HasSubstr("did not run")), HasSubstr("keep the round below 1 ms"),
                    Not(HasSubstr("tick.cost"))));
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

}  // namespace
}  // namespace twin::report::report_explanation_test
