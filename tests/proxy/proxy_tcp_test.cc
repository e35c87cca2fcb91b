// What a proxy does with connections: what passes, and how each end's end reaches the other.

#include <utility>

#include "proxy/proxy_fixture.h"
#include "twin/core/error.h"

namespace twin::proxy::proxy_tcp_test {
namespace {

constexpr auto kSuccess = static_cast<std::uint8_t>(MoveStatus::kSuccess);
constexpr auto kMotionStarted = static_cast<std::uint8_t>(MoveStatus::kMotionStarted);

class ProxyTcpTest : public ProxyTest {
 protected:
  /// The robot answers the Connect.
  static void Agree(Session& session) {
    const Bytes answer = fci::EncodeArmConnectAnswer(0, fci::ConnectStatus::kSuccess, 5);
    Send(session.robot, answer);
    EXPECT_EQ(Receive(session.client, answer.size()), answer);
  }
};

Bytes Pattern(std::size_t count) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 7 + i / 251);
  return bytes;
}

TEST_F(ProxyTcpTest, ARequestPassesAsItIsButForThePortInAConnect) {
  Start();
  fci::TcpStream client = ConnectArm();
  const Bytes connect = ArmRequest(3, fci::Connect{5, 43210});
  const Bytes move = ArmRequest(4, fci::Move{});
  Send(client, Join(connect, move));  // in one piece
  fci::TcpStream robot = AwaitConnection(robot_arm_);
  const Bytes came = Receive(robot, 16 + 68);
  ASSERT_EQ(came.size(), 16u + 68u);
  EXPECT_EQ(Bytes(came.begin(), came.begin() + 14), Bytes(connect.begin(), connect.begin() + 14));
  const std::uint16_t port = PortIn({came.begin(), came.begin() + 16});
  EXPECT_NE(port, 43210);
  EXPECT_NE(port, 0);
  EXPECT_EQ(Bytes(came.begin() + 16, came.end()), move);
}

TEST_F(ProxyTcpTest, AConnectThatComesByteByByteIsRewrittenToo) {
  Start();
  fci::TcpStream client = ConnectArm();
  for (const std::byte one : ArmRequest(0, fci::Connect{5, 43210})) {
    Send(client, {&one, 1});
    rt::Pause(std::chrono::microseconds(200));
  }
  fci::TcpStream robot = AwaitConnection(robot_arm_);
  const std::uint16_t port = PortIn(Receive(robot, 16));
  EXPECT_NE(port, 43210);
  EXPECT_NE(port, 0);
}

TEST_F(ProxyTcpTest, TheHandsConnectIsRewrittenToo) {
  Start();
  fci::TcpStream client = fci::TcpStream::Connect(proxy_->hand(), kLong);
  Bytes connect = fci::EncodeRequest(9, fci::HandRequest(fci::Connect{3, 43210}));
  Send(client, connect);
  fci::TcpStream robot = AwaitConnection(robot_hand_);
  Bytes came = Receive(robot, 14);
  ASSERT_EQ(came.size(), 14u);
  EXPECT_NE(Bytes(came.end() - 2, came.end()), Bytes(connect.end() - 2, connect.end()));
  came.resize(12);
  connect.resize(12);
  EXPECT_EQ(came, connect);
}

TEST_F(ProxyTcpTest, RequestsThatTheProtocolDoesNotKnowPassToo) {
  Start();
  Session session = OnConnect();
  Bytes unknown = ArmRequest(5, fci::StopMove{});
  unknown[0] = std::byte{0xee};  // the command
  Bytes odd = ArmRequest(6, fci::Connect{5, 43210});
  odd[8] = std::byte{15};  // the size: a Connect that is cut short
  odd.pop_back();
  Send(session.client, Join(unknown, odd));
  EXPECT_EQ(Receive(session.robot, unknown.size() + odd.size()), Join(unknown, odd));
}

TEST_F(ProxyTcpTest, AConnectWithoutAPortIsLeftForTheRobotToRefuse) {
  Start();
  fci::TcpStream client = ConnectArm();
  const Bytes connect = ArmRequest(0, fci::Connect{5, 0});
  Send(client, connect);
  fci::TcpStream robot = AwaitConnection(robot_arm_);
  EXPECT_EQ(Receive(robot, 16), connect);
}

TEST_F(ProxyTcpTest, AnswersPassByteForByteHoweverManyAndHoweverSlowlyTheyAreRead) {
  Start();
  Session session = OnConnect();
  const Bytes library = fci::EncodeModelLibraryAnswer(
      1, fci::ModelLibraryStatus::kSuccess,
      Pattern(std::size_t{12} << 20));  // more than the systems between keep
  Bytes came;
  std::span<const std::byte> left = library;
  while (came.size() < library.size()) {
    for (std::size_t sent = 1; sent > 0 && !left.empty(); left = left.subspan(sent)) {
      static_cast<void>(session.robot.Send(left, sent));
    }
    std::array<std::byte, 50'000> piece;
    std::size_t received = 0;
    ASSERT_LE(session.client.Receive(piece, received), fci::StreamResult::kPending);
    came.insert(came.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(received));
  }
  EXPECT_TRUE(came == library);
}

TEST_F(ProxyTcpTest, ARobotOfAnotherVersionSaysSoAndTheEndIsInOrder) {
  Start();
  Session session = OnConnect();
  const Bytes answer =
      fci::EncodeArmConnectAnswer(0, fci::ConnectStatus::kIncompatibleLibraryVersion, 4);
  Send(session.robot, answer);
  session.robot.Close();
  EXPECT_EQ(Receive(session.client, 15), answer);
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kClosed);
}

TEST_F(ProxyTcpTest, AClientThatLeavesInOrderDoesSoAtTheRobot) {
  Start();
  for (int round = 0; round < 3; ++round) {
    Session session = OnConnect();
    session.client.Close();
    EXPECT_EQ(AwaitEnd(session.robot), fci::StreamResult::kClosed);
  }
}

TEST_F(ProxyTcpTest, AClientThatVanishesDoesSoAtTheRobot) {
  Start();
  for (int round = 0; round < 3; ++round) {
    Session session = OnConnect();
    session.client.ResetConnection();
    EXPECT_EQ(AwaitEnd(session.robot), fci::StreamResult::kReset);
  }
}

TEST_F(ProxyTcpTest, ARobotThatBreaksItsConnectionBreaksTheClients) {
  Start();
  for (int round = 0; round < 3; ++round) {
    Session session = OnConnect();
    session.robot.ResetConnection();
    EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kReset);
  }
}

TEST_F(ProxyTcpTest, ARobotThatLeavesInOrderDoesSoAtTheClientWhenAllIsAnswered) {
  Start();
  Session session = OnConnect();
  Agree(session);
  const Bytes answer = fci::EncodeArmAnswer(fci::ArmCommand::kMove, 1, kMotionStarted);
  const Bytes end = fci::EncodeArmAnswer(fci::ArmCommand::kMove, 1, kSuccess);
  Send(session.client, ArmRequest(1, fci::Move{}));
  Send(session.robot, Join(answer, end));
  EXPECT_EQ(Receive(session.client, 26), Join(answer, end));
  session.robot.Close();
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kClosed);
}

// libfranka waits for ever on a connection that endpoints in order with an answer owed.
TEST_F(ProxyTcpTest, ARobotThatIsKilledInAMotionResetsTheClient) {
  Start();
  Session session = OnConnect();
  Agree(session);
  Send(session.client, ArmRequest(1, fci::Move{}));
  const Bytes answer = fci::EncodeArmAnswer(fci::ArmCommand::kMove, 1, kMotionStarted);
  Send(session.robot, answer);
  EXPECT_EQ(Receive(session.client, 13), answer);
  session.robot.Close();  // as the system does for a process that is killed
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kReset);
}

TEST_F(ProxyTcpTest, ARobotThatLeavesARequestUnansweredResetsTheClient) {
  Start();
  Session session = OnConnect();
  Agree(session);
  Send(session.client, ArmRequest(1, fci::AutomaticErrorRecovery{}));
  EXPECT_EQ(Receive(session.robot, 12).size(), 12u);
  session.robot.Close();
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kReset);
}

TEST_F(ProxyTcpTest, ARobotThatSendsNoAnswersLosesItsClient) {
  Start();
  Session session = OnConnect();
  Send(session.robot, Bytes(12));  // a frame of 0 bytes
  EXPECT_EQ(Receive(session.client, 12).size(), 12u);
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kReset);
  AwaitLine("sends what is no answer");
}

TEST_F(ProxyTcpTest, AClientOfARobotThatIsNotThereIsResetAndTheNextOneServed) {
  {
    const fci::TcpListener nobody({kElsewhere, 0});
    config_.robot_arm = nobody.local();  // refuses from now on
  }
  Start();
  for (int round = 0; round < 2; ++round) {
    fci::TcpStream client = ConnectArm();
    Send(client, ArmRequest(0, fci::Connect{5, 43210}));
    EXPECT_EQ(AwaitEnd(client), fci::StreamResult::kReset);
  }
  AwaitLine("refuses the connection");
}

TEST_F(ProxyTcpTest, ARobotThatReadsNoRequestsLosesItsClient) {
  Start();
  Session session = OnConnect();
  Bytes requests;
  for (std::uint32_t id = 1; id < 1000; ++id) {
    requests = Join(std::move(requests), ArmRequest(id, Setting(setting::CollisionBehavior())));
  }
  fci::StreamResult result = fci::StreamResult::kDone;
  while (result <= fci::StreamResult::kPending) {
    std::size_t sent = 0;  // in pieces of whole requests or not: it is refused for their number
    result = session.client.Send(requests, sent);
    std::rotate(requests.begin(), requests.begin() + static_cast<std::ptrdiff_t>(sent),
                requests.end());
  }
  EXPECT_EQ(result, fci::StreamResult::kReset);
  AwaitLine("takes no more requests");
}

TEST_F(ProxyTcpTest, AFurtherClientIsSentAwayAndTheFirstStays) {
  Start();
  Session session = OnConnect();
  fci::TcpStream second = ConnectArm();
  Send(second, ArmRequest(0, fci::Connect{5, 43210}));
  EXPECT_EQ(AwaitEnd(second), fci::StreamResult::kReset);
  const Bytes stop = ArmRequest(1, fci::StopMove{});
  Send(session.client, stop);
  EXPECT_EQ(Receive(session.robot, stop.size()), stop);
}

TEST_F(ProxyTcpTest, AConnectionThatSaysNothingWholeIsEnded) {
  config_.connect_timeout = std::chrono::milliseconds(30);
  Start();
  fci::TcpStream silent = ConnectArm();
  fci::TcpStream half = ConnectArm();
  Send(half, Bytes(7));
  EXPECT_EQ(AwaitEnd(silent), fci::StreamResult::kReset);
  EXPECT_EQ(AwaitEnd(half), fci::StreamResult::kReset);
  EXPECT_FALSE(robot_arm_.Accept());
}

TEST_F(ProxyTcpTest, ASilentConnectionKeepsNobodyOut) {
  Start();
  const fci::TcpStream silent = ConnectArm();
  const Session session = OnConnect();
  EXPECT_NE(session.robot_side.port, 0);
}

TEST_F(ProxyTcpTest, WhatIsNoFrameEndsTheSession) {
  Start();
  Session session = OnConnect();
  Send(session.client, Bytes(12));  // a frame of 0 bytes
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kReset);
  EXPECT_EQ(AwaitEnd(session.robot), fci::StreamResult::kClosed);
}

TEST_F(ProxyTcpTest, WhenItEndsBothEndsAreEndedInOrder) {
  Start();
  Session session = OnConnect();
  Agree(session);
  End();
  EXPECT_EQ(AwaitEnd(session.client), fci::StreamResult::kClosed);
  EXPECT_EQ(AwaitEnd(session.robot), fci::StreamResult::kClosed);
}

TEST_F(ProxyTcpTest, FaultsOutOfRangeAreNamed) {
  config_.command.duplication = 1.5;
  try {
    Start();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("link.command.duplication"), std::string::npos);
  }
}

}  // namespace
}  // namespace twin::proxy::proxy_tcp_test
