#include "twin/report/logged_motions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "record/temporary_folder.h"
#include "twin/record/cycle_record.h"
#include "twin/record/recorder.h"

namespace twin::report::report_logged_motions_test {
namespace {

using record::TemporaryFolder;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A session made by hand, one cycle after the other.
class LoggedMotionsTest : public ::testing::Test {
 protected:
  void Put(RobotMode mode, int count = 1) {
    for (int i = 0; i < count; ++i) {
      cycle_.at = Time(++k_ * kCycle);
      cycle_.state.robot_mode = mode;
      const bool moves = mode == RobotMode::kMove;
      cycle_.state.motion_generator_mode =
          moves ? MotionGeneratorMode::kJointPosition : MotionGeneratorMode::kIdle;
      cycle_.state.controller_mode = moves ? controller_ : ControllerMode::kOther;
      cycle_.fate = moves ? record::CommandFate::kServed : record::CommandFate::kNone;
      recorder_.Put(cycle_);
    }
  }
  /// Before the next cycle, as run::ToldEvents does.
  void Tell(std::string_view kind, std::string_view text) {
    recorder_.Event(Time((k_ + 1) * kCycle), kind, text);
  }
  LoggedSession Read() {
    recorder_.Finish();
    return ReadSession(folder_ / "a.mcap");
  }

  const TemporaryFolder folder_;
  record::Recorder recorder_{folder_ / "a.mcap",
                             {.scenario = "session",
                              .seed = 1,
                              .version = "0.1.0",
                              .drive = "lockstep",
                              .scenario_yaml = ""},
                             record::FullRing::kWait};
  record::CycleRecord cycle_;
  ControllerMode controller_ = ControllerMode::kJointImpedance;
  std::int64_t k_ = 0;
};

TEST_F(LoggedMotionsTest, FindsEachMotionWithItsClientKindAndEnd) {
  Put(RobotMode::kIdle, 5);
  Tell("client", "arm: 127.0.0.1:1000 connected; states go to its UDP port 7");
  Tell("client", "hand: 127.0.0.1:1001 connected; states go to its UDP port 8");
  Put(RobotMode::kIdle);
  Tell("motion", "started: joint_position motion under joint_impedance");
  Put(RobotMode::kMove, 10);
  Put(RobotMode::kIdle);
  Tell("motion", "finished");
  Tell("client", "arm: 127.0.0.1:1000 disconnected: it closed the connection");
  Put(RobotMode::kIdle);
  Tell("client", "arm: 127.0.0.1:2000 connected; states go to its UDP port 9");
  controller_ = ControllerMode::kExternalController;
  Put(RobotMode::kMove, 3);
  Put(RobotMode::kIdle);
  Tell("motion", "stopped");
  const LoggedSession session = Read();
  ASSERT_THAT(session.motions, SizeIs(2));
  const LoggedMotion& first = session.motions[0];
  EXPECT_EQ(first.begin, Time(7 * kCycle));
  EXPECT_EQ(first.end, Time(16 * kCycle));
  EXPECT_EQ(first.client, "127.0.0.1:1000");
  EXPECT_EQ(first.how, "finished");
  EXPECT_EQ(first.generator, MotionGeneratorMode::kJointPosition);
  EXPECT_EQ(first.controller, ControllerMode::kJointImpedance);
  EXPECT_EQ(first.served, 10U);
  EXPECT_FALSE(first.is_aborted());
  EXPECT_EQ(session.motions[1].client, "127.0.0.1:2000");
  EXPECT_EQ(session.motions[1].how, "stopped") << "told after the last cycle";
  EXPECT_FALSE(session.motions[1].peak_error) << "torques have no reference";
}

TEST_F(LoggedMotionsTest, AnEndToldAtTheNextMotionsFirstCycleIsThatOfTheOneBefore) {
  Put(RobotMode::kMove, 4);
  Put(RobotMode::kIdle);
  Tell("motion", "finished");
  Put(RobotMode::kMove, 4);
  Put(RobotMode::kIdle);
  const LoggedSession session = Read();
  ASSERT_THAT(session.motions, SizeIs(2));
  EXPECT_EQ(session.motions[0].how, "finished");
  EXPECT_EQ(session.motions[1].how, "ended") << "nothing was told";
}

TEST_F(LoggedMotionsTest, KnowsErrorsLossesAndTheLargestErrorOfTheReference) {
  cycle_.state.q_d[3] = 0.1;
  cycle_.state.q[3] = 0.104;
  cycle_.state.dq[6] = -0.25;
  Put(RobotMode::kMove);
  cycle_.state.q_d = cycle_.state.q;
  cycle_.lost_in_row = 3;
  Put(RobotMode::kMove, 2);
  cycle_.state.errors.set(static_cast<std::size_t>(RobotError::kJointReflex));
  Put(RobotMode::kReflex, 2);
  cycle_.state.errors.reset();
  Put(RobotMode::kMove);
  Put(RobotMode::kUserStopped);
  const LoggedSession session = Read();
  ASSERT_THAT(session.motions, SizeIs(2));
  const LoggedMotion& motion = session.motions[0];
  EXPECT_NEAR(motion.peak_error.value(), 0.004, 1e-15);
  EXPECT_EQ(motion.peak_speed, 0.25);
  EXPECT_EQ(motion.longest_loss, 3U);
  EXPECT_TRUE(motion.is_aborted());
  EXPECT_EQ(motion.how, R"(["joint_reflex"])");
  EXPECT_TRUE(session.motions[1].is_user_stopped);
  EXPECT_TRUE(session.motions[1].errors.none());
}

TEST_F(LoggedMotionsTest, ASessionWithoutMotionsIsEmpty) {
  Put(RobotMode::kIdle, 3);
  EXPECT_THAT(Read().motions, IsEmpty());
}

}  // namespace
}  // namespace twin::report::report_logged_motions_test
