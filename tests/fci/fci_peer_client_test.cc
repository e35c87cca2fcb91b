// The backend "fci" against a peer that others' programs have run against, and that shares nothing
// with this one. How fast this machine is decides nothing: the peer holds what is not answered.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fci/peer_process.h"
#include "plugins/backends.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"

namespace twin::test::fci_peer_client_test {
namespace {

using backend::MotionEnd;
using backend::ReadResult;
using backend::ReadRule;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};

std::string FaultOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const RobotFault& fault) {
    return fault.what();
  }
  return "no fault";
}

class PeerClientTest : public ::testing::Test {
 protected:
  void Connect(const std::vector<std::string>& options = {},
               backend::RobotTime time = backend::RobotTime::kWall) {
    peer_ = std::make_unique<PeerProcess>(options);
    robot_.plant.hand = plant::HandKind::kFrankaHand;
    connection_ = plugins::ConnectFci(
        {robot_,
         backend::RemoteRobot{clock_,
                              {.host = "127.0.0.1", .arm_port = peer_->arm_port(), .time = time}},
         nullptr});
  }
  backend::Backend& robot() { return *connection_.backend; }

  ReadResult Read() {
    Time at{};
    const Time limit = clock_.Now() + std::chrono::seconds(20);
    ReadResult result = ReadResult::kPending;
    while (result == ReadResult::kPending && clock_.Now() < limit) {
      static_cast<void>(
          connection_.arrival->AwaitUntil(clock_.Now() + std::chrono::milliseconds(20)));
      result = robot().Read(ReadRule::kNewest, state_, at);
    }
    return result;
  }
  /// Starts a motion and reads up to the first state that is answered.
  void StartMotion() {
    ASSERT_EQ(Read(), ReadResult::kState);
    robot().Start(kPosition);
    for (int i = 0; i < 1000 && state_.robot_mode != RobotMode::kMove; ++i) {
      ASSERT_EQ(Read(), ReadResult::kState);
    }
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
    ASSERT_EQ(Read(), ReadResult::kState);
  }
  /// Answers `states` states at most, while the motion lasts, with where joint 7 is to be.
  void Answer(int states, double q7, bool finished = false) {
    for (int i = 0; i < states && state_.robot_mode == RobotMode::kMove; ++i) {
      RobotCommand command;
      command.message_id = state_.message_id;
      command.q_c = state_.q_d;
      command.q_c[6] = q7;
      command.motion_generation_finished = finished;
      robot().Write(command);
      ASSERT_EQ(Read(), ReadResult::kState);
    }
  }

  MonotonicClock clock_;
  robot::RobotConfig robot_;
  std::unique_ptr<PeerProcess> peer_;
  backend::Connection connection_;
  RobotState state_;
};

TEST_F(PeerClientTest, ReadsWhatThePeerIs) {
  Connect();
  ASSERT_EQ(Read(), ReadResult::kState);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kOther);
  EXPECT_EQ(state_.m_ee, 0.73);
  EXPECT_DOUBLE_EQ(state_.q[3], -3 * M_PI / 4 + 0.2);
  EXPECT_NEAR(state_.F_T_EE[14], 0.1034, 1e-15);
  EXPECT_EQ(state_.O_ddP_O[2], -9.81);
}

TEST_F(PeerClientTest, MovesThePeerAndEndsWithSuccess) {
  Connect();
  StartMotion();
  const double q7 = state_.q_d[6] + 1e-5;
  Answer(20, q7);
  EXPECT_EQ(state_.q_d[6], q7);
  Answer(5000, q7, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(robot().Describe().last_end, MotionEnd::kSuccess);
}

TEST_F(PeerClientTest, ToldALoadThePeerShowsIt) {
  Connect();
  setting::Load load;
  load.m_load = 0.5;
  load.F_x_Cload = {0.01, 0.02, 0.03};
  robot().Configure(load);
  setting::StiffnessFrame frame;
  frame.EE_T_K[14] = 0.05;
  robot().Configure(frame);
  for (int i = 0; i < 1000 && state_.EE_T_K[14] == 0; ++i) ASSERT_EQ(Read(), ReadResult::kState);
  EXPECT_EQ(state_.m_load, 0.5);
  EXPECT_EQ(state_.F_x_Cload, load.F_x_Cload);
  EXPECT_EQ(state_.EE_T_K, frame.EE_T_K);
}

TEST_F(PeerClientTest, TellsTheErrorOfAReflexAndRecovers) {
  Connect({"--reflex-at", "20", "--reflex-idx", "7"});
  StartMotion();
  Answer(5000, state_.q_d[6]);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  const backend::Description description = robot().Describe();
  EXPECT_EQ(description.last_end, MotionEnd::kAborted);
  EXPECT_EQ(FormatErrors(description.last_errors), "[\"cartesian_reflex\"]");
  EXPECT_THAT(FaultOf([this] { robot().Start(kPosition); }),
              AllOf(HasSubstr("Move rejected"), HasSubstr("(\"Reflex\")"), HasSubstr("recover")));
  robot().Recover();
  StartMotion();
}

TEST_F(PeerClientTest, TellsAUserStop) {
  Connect({"--userstop-at", "20"});
  StartMotion();
  Answer(5000, state_.q_d[6]);
  EXPECT_EQ(state_.robot_mode, RobotMode::kUserStopped);
  EXPECT_EQ(robot().Describe().last_end, MotionEnd::kUserStopped);
  EXPECT_THAT(FaultOf([this] { robot().Start(kPosition); }),
              AllOf(HasSubstr("(\"User stopped\")"), HasSubstr("release the user stop")));
}

TEST_F(PeerClientTest, EndsAMotionThatIsStopped) {
  Connect();
  StartMotion();
  Answer(20, state_.q_d[6]);
  robot().Stop();
  for (int i = 0; i < 1000 && state_.robot_mode == RobotMode::kMove; ++i) Read();
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(robot().Describe().last_end, MotionEnd::kPreempted);
  EXPECT_NO_THROW(robot().Stop()) << "without a motion it has no effect";
}

TEST_F(PeerClientTest, LosesTheMotionWhenItAnswersTwentyStatesInARowNot) {
  Connect({"--strict"});
  StartMotion();
  // The first command that comes in time is what the peer counts from.
  Answer(200, state_.q_d[6]);
  for (int i = 0; i < 5000 && state_.robot_mode == RobotMode::kMove; ++i) {
    ASSERT_EQ(Read(), ReadResult::kState);
  }
  EXPECT_EQ(FormatErrors(robot().Describe().last_errors),
            "[\"communication_constraints_violation\"]");
}

TEST_F(PeerClientTest, RefusesASecondMotionAndSettingsWhileOneRuns) {
  Connect();
  StartMotion();
  EXPECT_THAT(FaultOf([this] { robot().Start(kPosition); }), HasSubstr("end the motion first"));
  EXPECT_THAT(FaultOf([this] { robot().Configure(setting::JointImpedance{}); }),
              AllOf(HasSubstr("Set Joint Impedance rejected"), HasSubstr("(\"Move\")")));
  Answer(5000, state_.q_d[6], true);
  EXPECT_EQ(robot().Describe().last_end, MotionEnd::kSuccess);
}

TEST_F(PeerClientTest, RefusesAPeerOfAnotherVersion) {
  const PeerProcess old({"--version", "4"});
  EXPECT_THAT(
      FaultOf([&] {
        static_cast<void>(plugins::ConnectFci(
            {robot_,
             backend::RemoteRobot{clock_, {.host = "127.0.0.1", .arm_port = old.arm_port()}},
             nullptr}));
      }),
      AllOf(HasSubstr("version 4"), HasSubstr("version 5")));
}

TEST_F(PeerClientTest, ARequestAtWhichTheConnectionIsClosedFails) {
  Connect({"--close-at", "fin"});
  EXPECT_THAT(FaultOf([this] { robot().Configure(setting::JointImpedance{}); }),
              AllOf(HasSubstr("Set Joint Impedance"), HasSubstr("closed the connection")));
  EXPECT_EQ(Read(), ReadResult::kLost);
  EXPECT_THAT(connection_.why_lost(), HasSubstr("closed the connection"));
  EXPECT_NO_THROW(robot().Stop()) << "it reaches nobody";
}

TEST_F(PeerClientTest, ARequestAtWhichTheConnectionIsResetFails) {
  Connect({"--close-at", "rst"});
  EXPECT_THAT(FaultOf([this] { robot().Configure(setting::JointImpedance{}); }),
              AllOf(HasSubstr("Set Joint Impedance"), HasSubstr("reset the connection")));
  EXPECT_EQ(Read(), ReadResult::kLost);
}

TEST_F(PeerClientTest, IsLostWhenThePeerSendsNoStates) {
  Connect({"--mute-udp"});
  EXPECT_EQ(Read(), ReadResult::kLost);
  EXPECT_THAT(connection_.why_lost(), AllOf(HasSubstr("no state"), HasSubstr("firewall")));
}

TEST_F(PeerClientTest, StatesThatAreTheClockAndDoNotComeAreSaidSoWithinSeconds) {
  Connect({"--mute-udp"}, backend::RobotTime::kStates);
  EXPECT_EQ(Read(), ReadResult::kLost);
  EXPECT_THAT(connection_.why_lost(), HasSubstr("no state"));
}

TEST_F(PeerClientTest, CommandsThePeersHand) {
  Connect();
  ASSERT_NE(connection_.hand, nullptr);
  backend::Hand& hand = *connection_.hand;
  const auto await = [&hand](HandTicket ticket) {
    std::optional<HandResult> result;
    for (int i = 0; i < 2000 && !result; ++i) {
      result = hand.Outcome(ticket);
      static_cast<void>(hand.ReadState());
      ::usleep(5000);
    }
    return result;
  };
  EXPECT_EQ(await(hand.Start(hand::Homing{})), HandResult::kSuccess);
  EXPECT_EQ(hand.ReadState().max_width, 0.08);
  EXPECT_EQ(await(hand.Start(hand::Move{0.06, 0.1})), HandResult::kSuccess);
  EXPECT_EQ(hand.ReadState().width, 0.06);
  EXPECT_EQ(await(hand.Start(hand::Grasp{.width = 0.03, .speed = 0.1, .force = 20})),
            HandResult::kSuccess);
  EXPECT_TRUE(hand.ReadState().is_grasped);
  EXPECT_EQ(await(hand.Start(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 20})),
            HandResult::kUnsuccessful);
  EXPECT_THROW(hand.Start(hand::Move{0.5, 0.1}), InputError);
}

}  // namespace
}  // namespace twin::test::fci_peer_client_test
