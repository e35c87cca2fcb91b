#include "twin/loop/drive.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loop/answer_paced_robot.h"
#include "loop/loop_fixture.h"
#include "twin/core/error.h"

namespace twin::loop::loop_state_time_drive_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// One motion with a robot whose time is its states.
class StateTimeDriveTest : public ::testing::Test {
 protected:
  StateTimeDriveTest() {
    controller_loop_.rate_hz = 100;
    tick_.source_rate_hz = 100;
  }

  RunReport Run(test::AnswerPacedBackend& robot, control::Controller& controller) {
    const auto drive = MakeStateTimeDrive(std::make_unique<MonotonicClock>(), robot.Connect());
    drive->Begin();
    return drive->Run({.backend = robot,
                       .controller = controller,
                       .modes = {},
                       .kind = kind_,
                       .tick = tick_,
                       .controller_loop = controller_loop_,
                       .seed = 1,
                       .time_limit = std::chrono::seconds(20),
                       .sink = &records_,
                       .progress = {},
                       .event = {},
                       .interrupted = interrupted_,
                       .attend = {}});
  }

  /// What was commanded, from the motion's first command on, without the ids.
  static std::vector<JointVector> Commanded(const test::AnswerPacedBackend& robot) {
    std::vector<JointVector> all;
    for (const RobotCommand& command : robot.commands) all.push_back(command.q_c);
    return all;
  }

  LoopKind kind_ = LoopKind::kAsynchronous;
  TickConfig tick_;
  ControllerLoopConfig controller_loop_;
  test::Keeper records_;
  const volatile bool* interrupted_ = nullptr;
};

TEST_F(StateTimeDriveTest, RunsAMotionToItsEnd) {
  test::AnswerPacedBackend robot(1);
  test::Swing swing;
  const RunReport report = Run(robot, swing);
  EXPECT_TRUE(report.succeeded()) << report.failure;
  EXPECT_EQ(swing.deactivated, 1);
  EXPECT_EQ(report.timings.written, robot.commands.size());
  EXPECT_NEAR(report.q_final[6], 0, 1e-12) << "nothing measures here";
}

TEST_F(StateTimeDriveTest, TheSameMotionGivesTheSameCommandsWhateverCameBefore) {
  std::vector<std::vector<JointVector>> runs;
  for (const std::uint64_t first_id : {std::uint64_t{1}, std::uint64_t{987'654'321}}) {
    test::AnswerPacedBackend robot(first_id);
    test::Swing swing;
    ASSERT_TRUE(Run(robot, swing).succeeded());
    runs.push_back(Commanded(robot));
  }
  ASSERT_GT(runs[0].size(), 1000u);
  EXPECT_EQ(runs[0], runs[1]);
}

TEST_F(StateTimeDriveTest, AnswersEveryStateFromTheMotionsSecondOn) {
  test::AnswerPacedBackend robot(1);
  test::Swing swing;
  ASSERT_TRUE(Run(robot, swing).succeeded());
  for (std::size_t i = 1; i < robot.commands.size(); ++i) {
    EXPECT_EQ(robot.commands[i].message_id, robot.commands[i - 1].message_id + 1);
  }
}

TEST_F(StateTimeDriveTest, AnswersAlsoTheStateAfterSomeThatWereLost) {
  tick_.period_tolerance = std::chrono::microseconds(250);
  test::AnswerPacedBackend robot(1);
  robot.leaps_at = 300;
  test::Swing swing;
  const RunReport report = Run(robot, swing);
  EXPECT_TRUE(report.succeeded()) << report.failure;
  EXPECT_EQ(report.timings.skipped_states, 3u);
  EXPECT_EQ(report.timings.anomalous, 0u);
}

TEST_F(StateTimeDriveTest, TheControllerHasItsOwnRate) {
  for (const double rate_hz : {100.0, 250.0, 1000.0}) {
    controller_loop_.rate_hz = rate_hz;
    tick_.source_rate_hz = rate_hz;
    test::AnswerPacedBackend robot(1);
    test::Swing swing;
    ASSERT_TRUE(Run(robot, swing).succeeded());
    // One state of the motion came before its first command.
    const double states = static_cast<double>(robot.commands.size()) + 1;
    EXPECT_NEAR(static_cast<double>(swing.updates), states * rate_hz / 1000, 1) << rate_hz;
  }
}

TEST_F(StateTimeDriveTest, TheControllerWakesInLostCyclesToo) {
  test::AnswerPacedBackend robot(1);
  robot.leaps_at = 300;
  test::Swing swing;
  const RunReport report = Run(robot, swing);
  ASSERT_TRUE(report.succeeded()) << report.failure;
  EXPECT_EQ(report.timings.skipped_states, 3u);
  EXPECT_EQ(report.controller_overruns, 0u);
}

TEST_F(StateTimeDriveTest, ItsTimesAreTheRobots) {
  test::AnswerPacedBackend robot(50);
  test::Swing swing;
  ASSERT_TRUE(Run(robot, swing).succeeded());
  for (const record::TickRecord& tick : records_.ticks) {
    EXPECT_EQ(tick.read, Time(kCycle * static_cast<std::int64_t>(tick.message_id - 50)));
    EXPECT_EQ(tick.written, tick.read);
  }
}

TEST_F(StateTimeDriveTest, RecordsEveryStateAndTheJerkOfItsReference) {
  test::AnswerPacedBackend robot(1);
  robot.leaps_at = 300;
  test::Swing swing;
  ASSERT_TRUE(Run(robot, swing).succeeded());
  ASSERT_EQ(records_.cycles.size(), records_.ticks.size());
  for (std::size_t i = 1; i < records_.cycles.size(); ++i) {
    const record::CycleRecord& last = records_.cycles[i - 1];
    const record::CycleRecord& cycle = records_.cycles[i];
    EXPECT_EQ(cycle.state.message_id, records_.ticks[i].message_id);
    EXPECT_EQ(cycle.at, records_.ticks[i].read);
    EXPECT_EQ(cycle.fate, record::CommandFate::kNone);
    const bool follows = cycle.state.message_id == last.state.message_id + 1;
    const double jerk = (cycle.state.ddq_d[6] - last.state.ddq_d[6]) * 1000;
    EXPECT_DOUBLE_EQ(cycle.dddq_d[6], follows ? jerk : 0);
  }
}

TEST_F(StateTimeDriveTest, TheBareLoopIsTheSameAtTheRobotsRate) {
  controller_loop_.rate_hz = 1000;
  tick_.source_rate_hz = 1000;
  test::AnswerPacedBackend first(1);
  test::Swing swing;
  ASSERT_TRUE(Run(first, swing).succeeded());
  kind_ = LoopKind::kBare;
  test::AnswerPacedBackend second(1);
  test::Swing again;
  ASSERT_TRUE(Run(second, again).succeeded());
  EXPECT_EQ(Commanded(first), Commanded(second));
}

TEST_F(StateTimeDriveTest, RefusesTheSynchronousLoop) {
  kind_ = LoopKind::kSynchronous;
  test::AnswerPacedBackend robot(1);
  test::Swing swing;
  EXPECT_THROW(static_cast<void>(Run(robot, swing)), InputError);
  EXPECT_TRUE(robot.commands.empty());
}

TEST_F(StateTimeDriveTest, EndsWhenTheConnectionIsLost) {
  test::AnswerPacedBackend robot(1);
  robot.gone_from = 200;
  test::Swing swing;
  const RunReport report = Run(robot, swing);
  EXPECT_FALSE(report.succeeded());
  EXPECT_THAT(report.failure, HasSubstr("connection"));
  EXPECT_EQ(report.evidence.size(), 32u);
  EXPECT_EQ(swing.deactivated, 1);
}

TEST_F(StateTimeDriveTest, StopsTheMotionAndSaysSoWhenItIsInterrupted) {
  const volatile bool interrupted = true;
  interrupted_ = &interrupted;
  test::AnswerPacedBackend robot(1);
  test::Swing swing;
  const RunReport report = Run(robot, swing);
  EXPECT_THAT(report.failure, StartsWith("interrupted"));
}

TEST_F(StateTimeDriveTest, StopsTheMotionOfAControllerThatGivesNoNumber) {
  /// Stands still, and goes mad after half a second.
  class Mad final : public control::Controller {
   public:
    control::CommandInterface command_interface() const noexcept override {
      return control::CommandInterface::kJointPosition;
    }
    void Activate(const RobotState& state, Time) override { q_ = state.q_d; }
    void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
      output.target.joint.q = q_;
      if (now > Time(std::chrono::milliseconds(500))) {
        output.target.joint.q[2] = std::numeric_limits<double>::quiet_NaN();
      }
    }
    void Deactivate() noexcept override {}

   private:
    JointVector q_{};
  };
  test::AnswerPacedBackend robot(1);
  Mad mad;
  const RunReport report = Run(robot, mad);
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_THAT(report.failure, HasSubstr("no valid command"));
  for (const RobotCommand& command : robot.commands) EXPECT_TRUE(std::isfinite(command.q_c[2]));
}

}  // namespace
}  // namespace twin::loop::loop_state_time_drive_test
