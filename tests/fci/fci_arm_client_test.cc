// The client of the arm against a robot of a script.
#include "twin/fci/arm_client.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <limits>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fci/fake_robot.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/fci/twin_sign.h"

namespace twin::fci::fci_arm_client_test {
namespace {

using test::FakeRobot;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::byte> Nothing(FakeRobot&, const Frame&) {
  return {};
}

std::vector<std::byte> Join(std::vector<std::byte> a, const std::vector<std::byte>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A script that answers every request with one status.
FakeRobot::Script Says(std::uint8_t status) {
  return [status](FakeRobot&, const Frame& request) {
    return EncodeArmAnswer(static_cast<ArmCommand>(request.head.command), request.head.command_id,
                           status);
  };
}

std::string FaultOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const RobotFault& fault) {
    return fault.what();
  }
  return "no fault";
}

/// Long enough for any machine to answer; short where a test waits it out.
ClientTimeout Short() {
  ClientTimeout timeout;
  timeout.answer = std::chrono::milliseconds(100);
  return timeout;
}

class ArmClientTest : public ::testing::Test {
 protected:
  ArmClient& Connect(FakeRobot::Script script, const ClientTimeout& timeout = {}) {
    client_.reset();
    robot_.emplace(HeadKind::kArm, std::move(script));
    return client_.emplace(clock_, "127.0.0.1", robot_->port(), timeout);
  }
  FakeRobot& robot() { return *robot_; }
  ArmClient& client() { return *client_; }

  /// Looks until a state comes; nothing else may.
  std::optional<RobotState> Await() {
    RobotState state;
    Time at{};
    const Time limit = clock_.Now() + std::chrono::seconds(10);
    while (clock_.Now() < limit) {
      switch (client().Receive(state, at)) {
        case ReceiveResult::kState: return state;
        case ReceiveResult::kLost: return {};
        case ReceiveResult::kPending: break;
      }
      static_cast<void>(client().arrival().AwaitUntil(limit));
    }
    return {};
  }

  MonotonicClock clock_;
  std::optional<FakeRobot> robot_;
  std::optional<ArmClient> client_;
};

TEST_F(ArmClientTest, AgreesOnTheVersion) {
  EXPECT_EQ(Connect(Nothing).version(), 5);
  EXPECT_FALSE(client().lost());
  EXPECT_EQ(client().WhyLost(), "");
}

TEST_F(ArmClientTest, NamesBothVersionsAndTheCureWhenTheyDiffer) {
  const auto refusal = [this](std::uint16_t version) {
    FakeRobot robot(HeadKind::kArm, Nothing);
    robot.OnlySpeaks(version);
    return FaultOf([&] { ArmClient client(clock_, "127.0.0.1", robot.port()); });
  };
  EXPECT_THAT(refusal(4),
              AllOf(HasSubstr("version 4"), HasSubstr("version 5"), HasSubstr("update the robot")));
  EXPECT_THAT(refusal(10),
              AllOf(HasSubstr("version 10"), HasSubstr("version 5"), HasSubstr("model: fr3")));
  EXPECT_THAT(refusal(9), AllOf(HasSubstr("version 9"), HasSubstr("libfranka 0.18")));
}

TEST_F(ArmClientTest, SaysThatNobodyListens) {
  std::uint16_t port = 0;
  {
    const FakeRobot gone(HeadKind::kArm, Nothing);
    port = gone.port();
  }
  EXPECT_THAT(FaultOf([&] { ArmClient client(clock_, "127.0.0.1", port); }),
              HasSubstr(std::to_string(port)));
}

TEST_F(ArmClientTest, TellsEveryStatusOfASetter) {
  for (const SetterStatus status :
       {SetterStatus::kSuccess, SetterStatus::kCommandNotPossibleRejected,
        SetterStatus::kInvalidArgumentRejected}) {
    Connect(Says(static_cast<std::uint8_t>(status)));
    EXPECT_EQ(client().Configure(setting::JointImpedance{}), status);
    EXPECT_EQ(client().Configure(setting::Filters{}), status);
  }
}

TEST_F(ArmClientTest, TakesNoStatusThatDoesNotExist) {
  Connect(Says(77));
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().Recover()); }),
              AllOf(HasSubstr("Automatic Error Recovery"), HasSubstr("77")));
}

TEST_F(ArmClientTest, MatchesAnswersByTheirIdWhateverTheOrder) {
  std::vector<std::byte> kept;
  Connect([&kept](FakeRobot&, const Frame& request) -> std::vector<std::byte> {
    const auto command = static_cast<ArmCommand>(request.head.command);
    // The first request's answer waits for the second's.
    if (kept.empty()) {
      kept = EncodeArmAnswer(command, request.head.command_id, 0);
      return {};
    }
    return Join(EncodeArmAnswer(command, request.head.command_id, 2), kept);
  });
  auto first = std::async(std::launch::async, [&] { return client().Recover(); });
  auto second = std::async(std::launch::async, [&] { return client().Recover(); });
  const RecoveryStatus a = first.get();
  const RecoveryStatus b = second.get();
  EXPECT_NE(a, b);
  EXPECT_EQ(std::min(a, b), RecoveryStatus::kSuccess);
  EXPECT_EQ(std::max(a, b), RecoveryStatus::kManualErrorRecoveryRequiredRejected);
}

TEST_F(ArmClientTest, KeepsTheSecondAnswerToAMove) {
  Connect([](FakeRobot&, const Frame& request) {
    const std::uint32_t id = request.head.command_id;
    return Join(EncodeArmAnswer(ArmCommand::kMove, id, 1),
                EncodeArmAnswer(ArmCommand::kMove, id, 6));
  });
  EXPECT_EQ(client().AwaitMotionEnd(Duration::zero()), std::nullopt);
  EXPECT_EQ(client().Move({}), MoveStatus::kMotionStarted);
  EXPECT_EQ(client().AwaitMotionEnd(std::chrono::seconds(10)), MoveStatus::kReflexAborted);
  EXPECT_EQ(client().AwaitMotionEnd(Duration::zero()), MoveStatus::kReflexAborted);
}

TEST_F(ArmClientTest, KnowsNoEndOfAMotionThatGoesOn) {
  Connect(Says(1));
  EXPECT_EQ(client().Move({}), MoveStatus::kMotionStarted);
  EXPECT_EQ(client().AwaitMotionEnd(std::chrono::milliseconds(20)), std::nullopt);
}

TEST_F(ArmClientTest, ARefusedMoveLeavesTheEndOfTheLastOne) {
  bool first = true;
  Connect([&first](FakeRobot&, const Frame& request) {
    const std::uint32_t id = request.head.command_id;
    if (!std::exchange(first, false)) return EncodeArmAnswer(ArmCommand::kMove, id, 3);
    return Join(EncodeArmAnswer(ArmCommand::kMove, id, 1),
                EncodeArmAnswer(ArmCommand::kMove, id, 0));
  });
  EXPECT_EQ(client().Move({}), MoveStatus::kMotionStarted);
  EXPECT_EQ(client().AwaitMotionEnd(std::chrono::seconds(10)), MoveStatus::kSuccess);
  EXPECT_EQ(client().Move({}), MoveStatus::kCommandNotPossibleRejected);
  EXPECT_EQ(client().AwaitMotionEnd(Duration::zero()), MoveStatus::kSuccess);
}

TEST_F(ArmClientTest, AConnectionThatIsClosedEndsTheWaitForAnAnswer) {
  Connect([](FakeRobot& robot, const Frame&) -> std::vector<std::byte> {
    robot.CloseAfterwards();
    return {};
  });
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().StopMove()); }),
              AllOf(HasSubstr("Stop Move"), HasSubstr("closed the connection")));
  RobotState state;
  Time at{};
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kLost);
  EXPECT_THAT(client().WhyLost(), HasSubstr("closed the connection"));
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().Recover()); }),
              HasSubstr("closed the connection"));
}

TEST_F(ArmClientTest, AConnectionThatIsResetEndsTheWaitForAnAnswer) {
  Connect([](FakeRobot& robot, const Frame&) -> std::vector<std::byte> {
    robot.ResetAfterwards();
    return {};
  });
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().StopMove()); }),
              AllOf(HasSubstr("Stop Move"), HasSubstr("reset the connection"),
                    HasSubstr("another program holds it")));
}

TEST_F(ArmClientTest, DoesNotWaitForAnAnswerForEver) {
  Connect(Nothing, Short());
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().Recover()); }), HasSubstr("0.1 s"));
  EXPECT_FALSE(client().lost());
}

TEST_F(ArmClientTest, ALateAnswerIsNobodys) {
  std::vector<std::byte> late;
  Connect(
      [&late](FakeRobot&, const Frame& request) -> std::vector<std::byte> {
        const auto command = static_cast<ArmCommand>(request.head.command);
        if (late.empty()) {
          late = EncodeArmAnswer(command, request.head.command_id, 0);
          return {};
        }
        return Join(late, EncodeArmAnswer(command, request.head.command_id, 2));
      },
      Short());
  EXPECT_THROW(static_cast<void>(client().Recover()), RobotFault);
  RecoveryStatus status{};
  for (int i = 0; i < 100; ++i) {  // until the machine answers within the short timeout
    try {
      status = client().Recover();
      break;
    } catch (const RobotFault&) {
    }
  }
  EXPECT_EQ(status, RecoveryStatus::kManualErrorRecoveryRequiredRejected);
}

TEST_F(ArmClientTest, AStreamOfNoFramesIsNoConnection) {
  Connect([](FakeRobot&, const Frame&) { return std::vector<std::byte>(12, std::byte{0xff}); });
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().Recover()); }),
              HasSubstr("sends what is no answer"));
}

TEST_F(ArmClientTest, AnAnswerWithTooFewBytesIsAFault) {
  Connect([](FakeRobot&, const Frame& request) {
    std::vector<std::byte> bytes =
        EncodeArmAnswer(static_cast<ArmCommand>(request.head.command), request.head.command_id, 0);
    bytes.pop_back();
    bytes[8] = std::byte{12};  // the size says so too
    return bytes;
  });
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client().Recover()); }),
              HasSubstr("sends an answer that is none"));
}

TEST_F(ArmClientTest, TellsAVirtualWall) {
  CartesianLimit wall;
  wall.object_world_size = {1, 2, 3};
  wall.object_activation = true;
  Connect([&wall](FakeRobot&, const Frame& request) {
    return EncodeCartesianLimitAnswer(request.head.command_id, SetterStatus::kSuccess, wall);
  });
  CartesianLimit told;
  EXPECT_EQ(client().CartesianLimitOf(3, told), SetterStatus::kSuccess);
  EXPECT_EQ(told.object_world_size, wall.object_world_size);
  EXPECT_TRUE(told.object_activation);
}

TEST_F(ArmClientTest, KnowsATwinByItsSign) {
  Connect([](FakeRobot&, const Frame& request) {
    const auto asked = std::get<ArmRequest>(ParseArmRequest(request));
    EXPECT_EQ(std::get<GetCartesianLimit>(asked).id, kTwinSign);
    return EncodeCartesianLimitAnswer(request.head.command_id, SetterStatus::kSuccess,
                                      TwinSign(TwinKind::kOnClock));
  });
  EXPECT_EQ(client().AskForTwin(), TwinKind::kOnClock);
}

TEST_F(ArmClientTest, KnowsATwinThatWaitsForAnswers) {
  Connect([](FakeRobot&, const Frame& request) {
    return EncodeCartesianLimitAnswer(request.head.command_id, SetterStatus::kSuccess,
                                      TwinSign(TwinKind::kInLockstep));
  });
  EXPECT_EQ(client().AskForTwin(), TwinKind::kInLockstep);
}

TEST_F(ArmClientTest, TakesNothingElseForATwin) {
  CartesianLimit close = TwinSign(TwinKind::kOnClock);
  close.object_world_size[2] = std::nextafter(close.object_world_size[2], 0);
  const auto gives = [](SetterStatus status, const CartesianLimit& wall) {
    return [status, wall](FakeRobot&, const Frame& request) {
      return EncodeCartesianLimitAnswer(request.head.command_id, status, wall);
    };
  };
  for (const auto& script :
       {FakeRobot::Script(gives(SetterStatus::kSuccess, {})),
        FakeRobot::Script(gives(SetterStatus::kSuccess, close)),
        FakeRobot::Script(
            gives(SetterStatus::kInvalidArgumentRejected, TwinSign(TwinKind::kOnClock))),
        Says(static_cast<std::uint8_t>(SetterStatus::kInvalidArgumentRejected)), Says(0)}) {
    Connect(script);
    EXPECT_EQ(client().AskForTwin(), TwinKind::kNone);
    EXPECT_FALSE(client().lost());
  }
  ClientTimeout timeout;
  timeout.connect = std::chrono::milliseconds(500);
  Connect(Nothing, timeout);
  EXPECT_EQ(client().AskForTwin(), TwinKind::kNone);
}

TEST_F(ArmClientTest, OfQueuedStatesTheNewestCountsWhateverTheirOrder) {
  Connect(Nothing);
  robot().SendStateId(5);
  ASSERT_EQ(Await()->message_id, 5);
  for (const std::uint64_t id : {7, 9, 8, 6}) robot().SendStateId(id);
  ASSERT_TRUE(client().arrival().AwaitUntil(clock_.Now() + std::chrono::seconds(10)));
  std::uint64_t newest = 0;
  RobotState state;
  Time at{};
  // Each datagram is there when its sender returns; all four may need several looks all the same.
  while (client().Receive(state, at) == ReceiveResult::kState) {
    EXPECT_GT(state.message_id, newest);
    newest = state.message_id;
  }
  EXPECT_EQ(newest, 9);
}

TEST_F(ArmClientTest, TakesNoStateTwiceAndNoneThatIsOlder) {
  Connect(Nothing);
  for (const std::uint64_t id : {5, 5, 4, 6}) robot().SendStateId(id);
  while (Await()->message_id != 6) {
  }
  EXPECT_EQ(client().counts().old, 2);
}

TEST_F(ArmClientTest, TakesStatesFromTheRobotsAddressOnly) {
  Connect(Nothing);
  UdpSocket stranger(clock_, {FakeRobot::kElsewhere, 0});
  robot().SendStateId(100, &stranger);
  robot().SendStateId(5);
  EXPECT_EQ(Await()->message_id, 5);
  EXPECT_EQ(client().counts().foreign, 1);
}

TEST_F(ArmClientTest, TakesNoDatagramThatIsNoState) {
  Connect(Nothing);
  StateBytes bytes{};
  RobotState state;
  state.message_id = 7;
  Encode(state, bytes);
  robot().SendDatagram(std::span(bytes).first(kStateBytes - 1));
  bytes[2280] = std::byte{200};  // the motion generator's mode
  robot().SendDatagram(bytes);
  robot().SendStateId(5);
  EXPECT_EQ(Await()->message_id, 5);
  EXPECT_EQ(client().counts().bad, 2);
}

TEST_F(ArmClientTest, LeavesTheCallersStateAloneWhenNoneComes) {
  Connect(Nothing);
  RobotState state;
  state.message_id = 42;
  Time at{};
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending);
  EXPECT_EQ(state.message_id, 42);
}

TEST_F(ArmClientTest, TakesStatesFromThePortOfTheFirstOnly) {
  Connect(Nothing);
  UdpSocket stranger(clock_, {FakeRobot::kHere, 0});
  robot().SendStateId(5);
  ASSERT_EQ(Await()->message_id, 5);
  robot().SendStateId(std::numeric_limits<std::uint64_t>::max(), &stranger);
  robot().SendStateId(6);
  EXPECT_EQ(Await()->message_id, 6);
}

TEST_F(ArmClientTest, AFloodOfStrangersHoldsNoStateBack) {
  Connect(Nothing);
  UdpSocket stranger(clock_, {FakeRobot::kHere, 0});
  robot().SendStateId(5);
  ASSERT_EQ(Await()->message_id, 5);
  for (int i = 0; i < 5000; ++i) robot().SendStateId(7, &stranger);  // more than a socket holds
  robot().SendStateId(6);
  ASSERT_TRUE(client().arrival().AwaitUntil(clock_.Now() + std::chrono::seconds(10)));
  RobotState state;
  Time at{};
  ASSERT_EQ(client().Receive(state, at), ReceiveResult::kState) << "in one look";
  EXPECT_EQ(state.message_id, 6);
}

TEST_F(ArmClientTest, TakesNoStateThatIsFurtherAheadThanTimeAllows) {
  Connect(Nothing);
  robot().SendStateId(5);
  ASSERT_EQ(Await()->message_id, 5);
  robot().SendStateId(std::numeric_limits<std::uint64_t>::max());
  robot().SendStateId(6);
  EXPECT_EQ(Await()->message_id, 6);
}

TEST_F(ArmClientTest, TakesAStateAfterAPauseThatWasAsLongAsItsIdTells) {
  Connect(Nothing);
  robot().SendStateId(1);
  ASSERT_EQ(Await()->message_id, 1);
  // 1.5 s in which nobody listens; the socket keeps what came first.
  for (std::uint64_t id = 2; id <= 1500; ++id) {
    robot().SendStateId(id);
    rt::Pause(std::chrono::milliseconds(1));
  }
  while (Await()->message_id < 30) {
  }
  robot().SendStateId(1501);
  while (Await()->message_id != 1501) {
  }
  EXPECT_EQ(client().counts().old, 0);
}

TEST_F(ArmClientTest, SendsCommandsToWhereTheFirstStateCameFrom) {
  Connect(Nothing);
  RobotCommand command;
  command.message_id = 1;
  client().Send(command);  // nowhere: no state yet
  UdpSocket other(robot().clock(), {FakeRobot::kHere, 0});
  robot().SendStateId(5);
  Await();
  robot().SendStateId(6, &other);
  command.message_id = 5;
  command.q_c[3] = -1.5;
  RobotState state;
  Time at{};
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending);
  client().Send(command);
  const auto received = robot().AwaitCommand();
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->message_id, 5);
  EXPECT_EQ(received->q_c, command.q_c);
}

TEST_F(ArmClientTest, AnswersAStateAgainThatComesAgainFromARobotThatWaits) {
  Connect(Nothing);
  client().AnswerAgain(std::chrono::seconds(5));
  robot().SendStateId(5);
  Await();
  RobotCommand command;
  command.message_id = 5;
  command.q_c[3] = -1.5;
  client().Send(command);
  ASSERT_TRUE(robot().AwaitCommand().has_value());
  RobotState state;
  Time at{};
  robot().SendStateId(5);
  ASSERT_TRUE(client().arrival().AwaitUntil(robot().clock().Now() + std::chrono::seconds(5)));
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending) << "no state of its own";
  const auto again = robot().AwaitCommand();
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->message_id, 5);
  EXPECT_EQ(again->q_c, command.q_c);
}

TEST_F(ArmClientTest, SaysWhatCameInPlaceOfStates) {
  ClientTimeout timeout;
  timeout.state = std::chrono::milliseconds(50);
  Connect(Nothing, timeout);
  robot().SendStateId(5);
  ASSERT_EQ(Await()->message_id, 5);
  RobotState state;
  Time at{};
  while (client().Receive(state, at) == ReceiveResult::kPending) {
    robot().SendStateId(4);
    robot().SendStateId(std::numeric_limits<std::uint64_t>::max());
    rt::Pause(std::chrono::milliseconds(1));
  }
  EXPECT_THAT(client().WhyLost(), AllOf(HasSubstr("no newer than one that had come"),
                                        HasSubstr("too far ahead"), Not(HasSubstr("firewall"))));
}

TEST_F(ArmClientTest, AStateThatHoldsNoNumberEndsTheConnection) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Connect(Nothing);
    robot().SendStateId(5);
    ASSERT_EQ(Await()->message_id, 5);
    RobotState state;
    state.message_id = 6;
    state.dq[3] = bad;
    robot().SendState(state);
    EXPECT_FALSE(Await().has_value());
    EXPECT_THAT(client().WhyLost(), AllOf(HasSubstr("dq"), HasSubstr("NaN or infinity")));
    state.message_id = 7;
    state.dq[3] = 0;
    robot().SendState(state);
    EXPECT_FALSE(Await().has_value()) << "gone for good";
  }
}

TEST_F(ArmClientTest, IsLostWhenNoStateComesForAsLongAsItsTimeout) {
  ClientTimeout timeout;
  timeout.state = std::chrono::milliseconds(50);
  Connect(Nothing, timeout);
  RobotState state;
  Time at{};
  const Time begin = clock_.Now();
  while (client().Receive(state, at) == ReceiveResult::kPending) {
    static_cast<void>(client().arrival().AwaitUntil(clock_.Now() + std::chrono::milliseconds(10)));
  }
  EXPECT_GT(clock_.Now() - begin, timeout.state);
  EXPECT_THAT(client().WhyLost(), AllOf(HasSubstr("no state"), HasSubstr("0.05 s")));
  robot().SendStateId(5);
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kLost) << "gone for good";
}

TEST_F(ArmClientTest, DoesNotCountAsSilenceWhatNobodyListenedTo) {
  ClientTimeout timeout;
  timeout.state = std::chrono::milliseconds(50);
  Connect(Nothing, timeout);
  rt::Pause(4 * timeout.state);
  RobotState state;
  Time at{};
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending);
}

TEST_F(ArmClientTest, BearsARestartOfItsClock) {
  Connect(Nothing);
  RobotState state;
  Time at{};
  rt::Pause(std::chrono::milliseconds(5));
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending);
  clock_.Restart();
  EXPECT_EQ(client().Receive(state, at), ReceiveResult::kPending);
  robot().SendStateId(5);
  EXPECT_EQ(Await()->message_id, 5);
}

TEST_F(ArmClientTest, AllocatesAndLocksNothingWhenItReceivesAndSends) {
  Connect(Nothing);
  RobotState sent;
  RobotState state;
  RobotCommand command;
  Time at{};
  const test::RealtimeGuard guard;
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    sent.message_id = id;
    robot().SendState(sent);
    while (client().Receive(state, at) == ReceiveResult::kPending) {
      static_cast<void>(client().arrival().AwaitUntil(clock_.Now() + std::chrono::seconds(1)));
    }
    command.message_id = state.message_id;
    client().Send(command);
    static_cast<void>(client().lost());
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_EQ(counts.locks, 0);
  EXPECT_EQ(state.message_id, 1000);
}

}  // namespace
}  // namespace twin::fci::fci_arm_client_test
