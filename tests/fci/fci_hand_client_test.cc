// The client of the hand against a hand of a script.
#include "twin/fci/hand_client.h"

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fci/fake_robot.h"
#include "twin/core/error.h"

namespace twin::fci::fci_hand_client_test {
namespace {

using test::FakeRobot;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<std::byte> Nothing(FakeRobot&, const Frame&) {
  return {};
}

std::vector<std::byte> AnswerOf(const Frame& request, HandResult result) {
  return EncodeHandAnswer(static_cast<HandCommandId>(request.head.command), request.head.command_id,
                          result);
}

std::string FaultOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const RobotFault& fault) {
    return fault.what();
  }
  return "no fault";
}

class HandClientTest : public ::testing::Test {
 protected:
  HandClient& Connect(FakeRobot::Script script) {
    client_.reset();
    hand_.emplace(HeadKind::kHand, std::move(script));
    return client_.emplace("127.0.0.1", hand_->port());
  }
  void SendState(std::uint32_t id, double width, UdpSocket* from = nullptr) {
    HandState state;
    state.message_id = id;
    state.width = width;
    HandStateBytes bytes{};
    Encode(state, bytes);
    hand_->SendDatagram(bytes, from);
  }
  std::optional<HandResult> AwaitOutcome(HandTicket ticket) {
    for (int i = 0; i < 10'000; ++i) {
      if (const auto result = client_->Outcome(ticket)) return result;
      rt::Pause(std::chrono::milliseconds(1));
    }
    return {};
  }

  std::optional<FakeRobot> hand_;
  std::optional<HandClient> client_;
};

TEST_F(HandClientTest, NamesBothVersionsWhenTheyDiffer) {
  FakeRobot old(HeadKind::kHand, Nothing);
  old.OnlySpeaks(2);
  EXPECT_THAT(FaultOf([&] { HandClient client("127.0.0.1", old.port()); }),
              AllOf(HasSubstr("version 2"), HasSubstr("version 3")));
}

TEST_F(HandClientTest, TellsHowACommandEnded) {
  for (const HandResult result :
       {HandResult::kSuccess, HandResult::kFail, HandResult::kUnsuccessful, HandResult::kAborted}) {
    Connect([result](FakeRobot&, const Frame& request) { return AnswerOf(request, result); });
    const HandTicket ticket = client_->Start(hand::Move{0.05, 0.1});
    EXPECT_GT(ticket, 0);
    EXPECT_EQ(AwaitOutcome(ticket), result);
    EXPECT_EQ(client_->Outcome(ticket), result) << "and again";
  }
}

TEST_F(HandClientTest, SpeaksToAVacuumGripperByItsNumbersAndReadsItsStates) {
  std::vector<std::uint32_t> asked;
  hand_.emplace(HeadKind::kHand, [&asked](FakeRobot&, const Frame& request) {
    asked.push_back(request.head.command);
    return AnswerOf(request, HandResult::kUnsuccessful);
  });
  hand_->Speaks(1);
  client_.emplace("127.0.0.1", hand_->port(), ClientTimeout(), nullptr, HandDevice::kCobotPump);
  VacuumStateBytes bytes{};
  Encode(VacuumState{.message_id = 7, .part_present = true, .vacuum = 612}, bytes);
  hand_->SendDatagram(bytes, nullptr);
  const HandState state = client_->State();
  ASSERT_TRUE(state.pump);
  EXPECT_EQ(state.pump->vacuum, 612);
  EXPECT_EQ(state.message_id, 7u);
  EXPECT_TRUE(state.is_grasped);
  EXPECT_EQ(AwaitOutcome(client_->Start(hand::Vacuum{.vacuum = 60, .timeout_ms = 100})),
            HandResult::kUnsuccessful);
  EXPECT_EQ(AwaitOutcome(client_->Start(hand::DropOff{100})), HandResult::kUnsuccessful);
  EXPECT_EQ(AwaitOutcome(client_->Start(hand::Stop())), HandResult::kUnsuccessful);
  EXPECT_EQ(asked, (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST_F(HandClientTest, DoesNotWaitForACommandToEnd) {
  Connect(Nothing);
  const HandTicket ticket = client_->Start(hand::Homing{});
  EXPECT_EQ(client_->Outcome(ticket), std::nullopt);
}

TEST_F(HandClientTest, KnowsWhatBecameOfTheLastCommandWhenANewOneHasStarted) {
  std::optional<std::uint32_t> running;
  Connect([&running](FakeRobot&, const Frame& request) -> std::vector<std::byte> {
    std::vector<std::byte> answer;
    if (running) answer = EncodeHandAnswer(HandCommandId::kMove, *running, HandResult::kAborted);
    running = request.head.command_id;
    if (request.head.command != static_cast<std::uint32_t>(HandCommandId::kStop)) return answer;
    const auto stopped = AnswerOf(request, HandResult::kSuccess);
    answer.insert(answer.end(), stopped.begin(), stopped.end());
    return answer;
  });
  const HandTicket first = client_->Start(hand::Move{0.07, 0.01});
  const HandTicket second = client_->Start(hand::Move{0.01, 0.01});
  EXPECT_EQ(client_->Outcome(first), HandResult::kAborted);
  EXPECT_EQ(client_->Outcome(second), std::nullopt);
  const HandTicket stop = client_->Start(hand::Stop{});
  EXPECT_EQ(client_->Outcome(second), HandResult::kAborted);
  EXPECT_EQ(client_->Outcome(stop), HandResult::kSuccess);
}

TEST_F(HandClientTest, RemembersTheLastEight) {
  Connect([](FakeRobot&, const Frame& request) { return AnswerOf(request, HandResult::kSuccess); });
  const HandTicket first = client_->Start(hand::Stop{});
  for (int i = 0; i < 7; ++i) client_->Start(hand::Stop{});
  EXPECT_EQ(client_->Outcome(first), HandResult::kSuccess);
  client_->Start(hand::Stop{});
  EXPECT_EQ(client_->Outcome(first), HandResult::kAborted);
}

TEST_F(HandClientTest, TellsTheNewestState) {
  Connect(Nothing);
  SendState(20, 0.04);
  EXPECT_EQ(client_->State().width, 0.04);
  SendState(40, 0.05);
  SendState(30, 0.01);
  for (int i = 0; i < 10'000 && client_->State().message_id < 40; ++i) {
    rt::Pause(std::chrono::milliseconds(1));
  }
  rt::Pause(std::chrono::milliseconds(20));
  EXPECT_EQ(client_->State().width, 0.05);
}

TEST_F(HandClientTest, TellsTheNewestStateWhenIdsBeginAnew) {
  Connect(Nothing);
  SendState(std::numeric_limits<std::uint32_t>::max(), 0.04);
  EXPECT_EQ(client_->State().width, 0.04);
  SendState(3, 0.05);
  SendState(std::numeric_limits<std::uint32_t>::max() - 5, 0.01);
  for (int i = 0; i < 10'000 && client_->State().message_id != 3; ++i) {
    rt::Pause(std::chrono::milliseconds(1));
  }
  rt::Pause(std::chrono::milliseconds(20));
  EXPECT_EQ(client_->State().width, 0.05);
}

TEST_F(HandClientTest, TakesStatesFromThePortOfTheFirstOnly) {
  Connect(Nothing);
  UdpSocket stranger(hand_->clock(), {FakeRobot::kHere, 0});
  SendState(5, 0.05);
  ASSERT_EQ(client_->State().message_id, 5);
  SendState(std::numeric_limits<std::uint32_t>::max(), 0.01, &stranger);
  SendState(6, 0.06);
  while (client_->State().message_id < 6) {
  }
  EXPECT_EQ(client_->State().message_id, 6);
}

TEST_F(HandClientTest, SaysThatNoStateComes) {
  FakeRobot hand(HeadKind::kHand, Nothing);
  ClientTimeout timeout;
  timeout.state = std::chrono::milliseconds(50);
  HandClient client("127.0.0.1", hand.port(), timeout);
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client.State()); }), HasSubstr("0.05 s"));
}

TEST_F(HandClientTest, AConnectionThatIsClosedIsAFault) {
  Connect([](FakeRobot& hand, const Frame&) -> std::vector<std::byte> {
    hand.CloseAfterwards();
    return {};
  });
  const HandTicket ticket = client_->Start(hand::Homing{});
  EXPECT_THAT(FaultOf([&] { static_cast<void>(AwaitOutcome(ticket)); }),
              HasSubstr("closed the connection"));
  EXPECT_THAT(FaultOf([&] { static_cast<void>(client_->State()); }),
              HasSubstr("closed the connection"));
}

}  // namespace
}  // namespace twin::fci::fci_hand_client_test
