#include "twin/report/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "record/temporary_folder.h"
#include "report/gnuplot.h"
#include "report/run_data.h"
#include "report/run_plots.h"
#include "report/script.h"
#include "support/panda_limits.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/record/recorder.h"

namespace twin::report::report_plots_test {
namespace {

using record::ReadText;
using record::TemporaryFolder;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kScenario = "a<b & 'c' \"d\" \\ {e_f}\n$g `h`";

/// A noisy run: nothing in it is easy to draw in few points.
void Record(const std::filesystem::path& path, int cycles, double odd_value = 0) {
  record::Recorder recorder(path,
                            {.scenario = kScenario,
                             .seed = 1,
                             .version = "0.1.0",
                             .drive = "lockstep",
                             .scenario_yaml = ""},
                            record::FullRing::kWait);
  const Random random(1, RandomStream::kTest);
  record::CycleRecord cycle;
  record::TickRecord tick;
  for (int k = 0; k < cycles; ++k) {
    cycle.at = Time(k * kCycle);
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      const double value = random.Normal(static_cast<std::uint64_t>(k), i);
      cycle.state.q[i] = cycle.state.q_d[i] = value;
      cycle.state.dq[i] = cycle.state.dq_d[i] = cycle.dddq_d[i] = value;
    }
    if (k == 3) cycle.dddq_d[0] = cycle.state.q[1] = odd_value;
    cycle.fate = k % 50 == 0 ? record::CommandFate::kHeld : record::CommandFate::kServed;
    cycle.state.robot_mode = RobotMode::kMove;
    cycle.state.control_command_success_rate = 0.98;
    recorder.Put(cycle);
    tick.read = cycle.at;
    tick.written = cycle.at + Duration(20'000 + k % 13);
    recorder.Put(tick);
  }
  recorder.Finish();
}

TEST(WritePlotsTest, DrawsItsFilesInBoundedSize) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 18'320);
  const auto paths = WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "plots");
  std::vector<std::string> names;
  for (const auto& path : paths) {
    names.push_back(path.filename());
    EXPECT_EQ(path.parent_path(), folder / "plots");
    EXPECT_GT(std::filesystem::file_size(path), 10'000U) << path;
    EXPECT_LT(std::filesystem::file_size(path), 500'000U) << path;
    EXPECT_THAT(ReadText(path), HasSubstr("</svg>"));
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder / "plots")) {
    EXPECT_EQ(entry.path().extension(), ".svg") << "something was left behind";
  }
  for (const std::string& name : names) EXPECT_THAT(kPlotFiles, Contains(name));
  EXPECT_THAT(
      names, ElementsAre("joints.svg", "tracking.svg", "velocities.svg", "jerk.svg", "served.svg"));
}

/// Records a motion of 100 cycles whose margin falls to 0.25; joint 3 is kept back in each tenth.
void RecordFiltered(const std::filesystem::path& path) {
  record::Recorder recorder(path, {}, record::FullRing::kWait);
  for (int k = 0; k < 100; ++k) {
    record::CycleRecord cycle;
    cycle.at = Time(k * kCycle);
    cycle.state.robot_mode = RobotMode::kMove;
    recorder.Put(cycle);
    record::TickRecord tick;
    tick.action = record::TickAction::kWritten;
    tick.read = cycle.at;
    tick.written = cycle.at + Duration(20'000);
    tick.margin = k == 40 ? 0.25 : 0.5;
    tick.kept_back = k % 10 == 0 ? 0b100 : 0;
    recorder.Put(tick);
  }
  recorder.Finish();
}

TEST(WritePlotsTest, DrawsWhatTheViabilityFilterDidWhereThereWasOne) {
  const TemporaryFolder folder;
  RecordFiltered(folder / "a.mcap");
  const auto paths = WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "plots");
  EXPECT_EQ(paths.back().filename(), "viability.svg");
  EXPECT_THAT(kPlotFiles, Contains(std::string("viability.svg")));
  EXPECT_THAT(ReadText(paths.back()),
              AllOf(HasSubstr("at least 0.25, at 0.04 s"), HasSubstr("10 of 100 (10 %)")));
}

TEST(RunDataTest, KnowsWhichJointWasKeptBackWhen) {
  const TemporaryFolder folder;
  RecordFiltered(folder / "a.mcap");
  const RunData run = ReadRun(folder / "a.mcap");
  EXPECT_EQ(run.filter.of_joint[2], 10U);
  EXPECT_TRUE(run.kept_back.Curve(0).empty());
  const auto third = run.kept_back.Curve(2);
  ASSERT_FALSE(third.empty());
  EXPECT_EQ(third.front().value, 3);
}

/// Records a motion of 100 cycles that an error ends in cycle `aborted`, if it is one of them; q is
/// behind q_d by 2 mrad times the joint's number.
void RecordAbort(const std::filesystem::path& path, int aborted, bool explained, bool two_errors) {
  record::RunInfo info;
  info.scenario = "outage";
  record::Recorder recorder(path, info, record::FullRing::kWait);
  for (int k = 0; k < 100; ++k) {
    record::CycleRecord cycle;
    cycle.at = Time(k * kCycle);
    if (k < aborted) cycle.state.controller_mode = ControllerMode::kJointImpedance;
    for (std::size_t i = 0; i < kJoints; ++i) {
      cycle.state.q_d[i] = 0.5;
      cycle.state.q[i] = 0.5 - 2e-3 * static_cast<double>(i + 1);
    }
    if (k >= aborted) {
      const auto set = [&cycle](RobotError error) {
        cycle.state.errors.set(static_cast<std::size_t>(error));
      };
      set(RobotError::kCommunicationConstraintsViolation);
      if (two_errors) set(RobotError::kJointVelocityViolation);
      cycle.violated = explained && k == aborted;
      cycle.violation.error = RobotError::kCommunicationConstraintsViolation;
    }
    recorder.Put(cycle);
  }
  recorder.Finish();
}

/// Title of the figures of a log.
std::string TitleOf(const std::filesystem::path& log) {
  return Title(ReadRun(log), "x");
}

TEST(RunDataTest, NamesTheErrorThatEndedTheMotion) {
  const TemporaryFolder folder;
  const auto log = folder / "a.mcap";
  RecordAbort(log, 40, true, false);
  EXPECT_EQ(TitleOf(log), "outage: x, aborted at 0.04 s: communication_constraints_violation");
  RecordAbort(log, 40, true, true);
  EXPECT_EQ(TitleOf(log),
            "outage: x, aborted at 0.04 s: communication_constraints_violation and 1 more");
  RecordAbort(log, 40, false, true);
  EXPECT_EQ(TitleOf(log), "outage: x, aborted at 0.04 s: joint_velocity_violation and 1 more")
      << "without an explanation the first of those set";
  RecordAbort(log, 100, true, true);
  EXPECT_EQ(TitleOf(log), "outage: x");
}

/// Records motions of 20 cycles with rests of 10 cycles between them.
void RecordMotions(const std::filesystem::path& path, int motions) {
  record::Recorder recorder(path, {}, record::FullRing::kWait);
  for (int k = 0; k < 30 * motions; ++k) {
    record::CycleRecord cycle;
    cycle.at = Time(k * kCycle);
    cycle.state.robot_mode = k % 30 < 20 ? RobotMode::kMove : RobotMode::kIdle;
    recorder.Put(cycle);
  }
  recorder.Finish();
}

TEST(RunDataTest, TellsWhereEachMotionBegins) {
  const TemporaryFolder folder;
  const auto log = folder / "a.mcap";
  RecordMotions(log, 3);
  EXPECT_THAT(ReadRun(log).motions, ElementsAre(0, 0.03, 0.06));
  const Figure figure = TrackingFigure(ReadRun(log));
  EXPECT_EQ(figure.values.at("motions"), 3);
  EXPECT_EQ(figure.values.at("motion_3"), 0.06);
  EXPECT_THAT(DrawPlot("run/", figure), HasSubstr("<text>3</text>"));
  RecordMotions(log, 1);
  EXPECT_EQ(TrackingFigure(ReadRun(log)).values.at("motions"), 0)
      << "a single motion needs no mark";
}

TEST(RunDataTest, MeasuresHowFarTheArmIsBehind) {
  const TemporaryFolder folder;
  RecordAbort(folder / "a.mcap", 100, false, false);
  const RunData run = ReadRun(folder / "a.mcap");
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(run.peak_error[i], 2.0 * static_cast<double>(i + 1), 1e-9);
    EXPECT_NEAR(run.error.Curve(i).front().value, run.peak_error[i], 1e-9) << "positive: behind";
  }
}

/// A motion under torques, 5 mrad behind its target.
void RecordTorques(const std::filesystem::path& path) {
  record::Recorder recorder(path, record::RunInfo(), record::FullRing::kWait);
  for (std::uint64_t k = 1; k <= 50; ++k) {
    record::CycleRecord cycle;
    cycle.state.message_id = k;
    cycle.state.controller_mode = ControllerMode::kExternalController;
    cycle.state.q.fill(0.25);
    cycle.state.tau_J.fill(-8);
    cycle.state.tau_J_d.fill(2);
    recorder.Put(cycle);
    record::TickRecord tick;
    tick.message_id = k;
    tick.q_ext.fill(0.255);
    tick.dq_ext.fill(0.125);
    recorder.Put(tick);
  }
  recorder.Finish();
}

TEST(RunDataTest, MeasuresUnderTorquesHowFarTheArmIsFromItsTarget) {
  const TemporaryFolder folder;
  RecordTorques(folder / "a.mcap");
  const RunData run = ReadRun(folder / "a.mcap");
  EXPECT_TRUE(run.by_torque);
  EXPECT_NEAR(run.peak_error[6], 5, 1e-9);
  EXPECT_THAT(TrackingFigure(run).names, Contains(HasSubstr("q_ext - q")));
}

TEST(RunFiguresTest, ShowUnderTorquesTheTargetInsteadOfAReferenceThatStandsStill) {
  const TemporaryFolder folder;
  RecordTorques(folder / "a.mcap");
  const RunData run = ReadRun(folder / "a.mcap");
  const JointLimits limits = test::PandaLimits();
  const Figure joints = JointsFigure(run, limits);
  EXPECT_THAT(joints.names, AllOf(Contains("q_ext, target"), Not(Contains(HasSubstr("q_d")))));
  EXPECT_EQ(joints.tables.at("reference").rows.front().back(), 0.255);
  const Figure velocities = VelocitiesFigure(run, limits);
  EXPECT_THAT(velocities.names,
              AllOf(Contains(HasSubstr("dq_ext")), Not(Contains(HasSubstr("dq_d")))));
  EXPECT_EQ(velocities.tables.at("reference").rows.front().back(), 0.125);
  const Figure torques = TorquesFigure(run, limits);
  EXPECT_THAT(torques.names, AllOf(Contains("joint 1: peak 8 of 87 Nm (9.2 %)"),
                                   Contains(HasSubstr("joint 7: peak 8 of 12"))));
  EXPECT_EQ(torques.tables.at("measured").rows.front().back(), -8);
  EXPECT_EQ(torques.tables.at("reference").rows.front().back(), 2);
}

TEST(WritePlotsTest, DrawsTorquesInsteadOfJerkUnderTorques) {
  const TemporaryFolder folder;
  RecordTorques(folder / "a.mcap");
  WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "plots");
  EXPECT_TRUE(std::filesystem::exists(folder / "plots" / "torques.svg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "plots" / "jerk.svg"));
}

TEST(RunFiguresTest, MarkTheAbortInEveryFigureWhenThereIsOne) {
  const TemporaryFolder folder;
  RecordAbort(folder / "a.mcap", 40, true, false);
  RecordAbort(folder / "b.mcap", 100, true, false);
  const JointLimits limits = test::PandaLimits();
  for (const auto& [log, marked] : {std::pair{"a.mcap", true}, {"b.mcap", false}}) {
    const RunData run = ReadRun(folder / log);
    for (const Figure& figure :
         {JointsFigure(run, limits), TrackingFigure(run), VelocitiesFigure(run, limits),
          JerkFigure(run, limits), ServedFigure(run)}) {
      EXPECT_EQ(figure.values.at("aborted"), marked ? 1 : 0) << figure.id;
      EXPECT_EQ(figure.values.at("abort"), marked ? 0.04 : 0) << figure.id;
      EXPECT_EQ(DrawPlot("run/", figure).find("rgb(122,  42, 144)") != std::string::npos, marked)
          << figure.id;
    }
  }
}

TEST(WritePlotsTest, SaysWhatEndedTheMotionAndWhen) {
  const TemporaryFolder folder;
  RecordAbort(folder / "a.mcap", 40, true, false);
  for (const auto& path : WritePlots(folder / "a.mcap", test::PandaLimits(), folder.path())) {
    EXPECT_THAT(ReadText(path),
                HasSubstr("aborted at 0.04 s: communication_constraints_violation"));
    EXPECT_THAT(ReadText(path), HasSubstr("rgb(122,  42, 144)")) << "the mark's colour";
  }
}

TEST(WritePlotsTest, SameLogGivesSameBytes) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 300);
  const auto first = WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "1");
  const auto second = WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "2");
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(ReadText(first[i]), ReadText(second[i]));
}

TEST(WritePlotsTest, ShowsTheNameOfTheScenarioAsItIs) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 10);
  const auto paths = WritePlots(folder / "a.mcap", test::PandaLimits(), folder.path());
  EXPECT_THAT(ReadText(paths[0]),
              HasSubstr("a&lt;b &amp; 'c' \"d\" \\ {e_f} $g `h`: joint positions"));
}

TEST(WritePlotsTest, TellsThatTheRunWasKilled) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 10);
  std::filesystem::resize_file(folder / "a.mcap",
                               std::filesystem::file_size(folder / "a.mcap") - 1);
  const auto paths = WritePlots(folder / "a.mcap", test::PandaLimits(), folder.path());
  EXPECT_THAT(ReadText(paths[0]), HasSubstr("the run was killed"));
}

TEST(WritePlotsTest, DrawsARunOfOneCycleAndNumbersThatAreNone) {
  const TemporaryFolder folder;
  Record(folder / "one.mcap", 1);
  EXPECT_NO_THROW(WritePlots(folder / "one.mcap", test::PandaLimits(), folder.path()));
  for (const double odd : {std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN(), 1e300, 1e-320}) {
    Record(folder / "odd.mcap", 10, odd);
    EXPECT_NO_THROW(WritePlots(folder / "odd.mcap", test::PandaLimits(), folder.path())) << odd;
  }
}

TEST(WritePlotsTest, RefusesALogWithoutCycles) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 0);
  EXPECT_THROW(WritePlots(folder / "a.mcap", test::PandaLimits(), folder.path()), InputError);
}

TEST(WritePlotsTest, RefusesLimitsThatAreNone) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 1);
  EXPECT_THROW(WritePlots(folder / "a.mcap", JointLimits{}, folder.path()), InputError);
}

TEST(WritePlotsTest, ReportsAFolderThatCannotBeMade) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 1);
  EXPECT_THROW(WritePlots(folder / "a.mcap", test::PandaLimits(), folder / "a.mcap" / "plots"),
               EnvironmentError);
}

TEST(SvgOfTest, NamesTheCureWhenGnuplotIsMissing) {
  const TemporaryFolder folder;
  const std::string path = ::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);
  std::string text;
  try {
    WriteSvg(SvgOf(""), folder / "a.svg");
  } catch (const EnvironmentError& error) {
    text = error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(text, HasSubstr("apt-get install gnuplot-nox"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SvgOfTest, PassesOnWhatGnuplotComplainsAbout) {
  const TemporaryFolder folder;
  try {
    WriteSvg(SvgOf("set terminal svg\nplot nonsense\n"), folder / "a.svg");
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("undefined variable: nonsense"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SvgOfTest, NoticesAPictureThatIsNotWhole) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteSvg(SvgOf("set terminal svg\n"), folder / "a.svg"), EnvironmentError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ScriptTest, QuotesForGnuplot) {
  EXPECT_EQ(Quote("it's\ta \\ \x7f"), "'it''s a \\  '");
}

}  // namespace
}  // namespace twin::report::report_plots_test
