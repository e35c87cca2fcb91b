// What a proxy does with datagrams, over real sockets. What becomes of each is proxy_lane_test's.

#include <cstring>
#include <utility>

#include "proxy/proxy_fixture.h"
#include "twin/core/random.h"

namespace twin::proxy::proxy_udp_test {
namespace {

using std::chrono::milliseconds;

class ProxyUdpTest : public ProxyTest {
 protected:
  static std::array<std::byte, 8> Content(std::uint64_t number) {
    std::array<std::byte, 8> bytes{};
    std::memcpy(bytes.data(), &number, sizeof number);
    return bytes;
  }
  /// The next datagram's number; where it came from is kept.
  std::uint64_t Await(fci::UdpSocket& socket) {
    std::array<std::byte, 8> bytes{};
    for (;;) {
      if (const auto datagram = socket.Receive(bytes)) {
        from_ = datagram->from;
        std::uint64_t number = 0;
        std::memcpy(&number, bytes.data(), sizeof number);
        return number;
      }
      static_cast<void>(socket.AwaitUntil(clock_.Now() + kLong));
    }
  }
  /// Where the client sees states come from: one passes.
  fci::Endpoint ClientSide(const Session& session) {
    robot_udp_.Send(Content(0), session.robot_side);
    EXPECT_EQ(Await(client_udp_), 0u);
    return from_;
  }

  fci::Endpoint from_;
};

TEST_F(ProxyUdpTest, StatesComeFromWhereTheClientConnectedAndCommandsGoToWhereStatesComeFrom) {
  config_.address = kElsewhere;
  Start();
  const Session session = OnConnect();
  const fci::Endpoint client_side = ClientSide(session);
  EXPECT_EQ(client_side.address, kElsewhere);
  client_udp_.Send(Content(41), client_side);
  EXPECT_EQ(Await(robot_udp_), 41u);
  EXPECT_EQ(from_, session.robot_side);
}

TEST_F(ProxyUdpTest, ADatagramPassesByteForByte) {
  Start();
  const Session session = OnConnect();
  std::array<std::byte, 2373> sent{};
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::byte>(i * 13);
  robot_udp_.Send(sent, session.robot_side);
  ASSERT_TRUE(client_udp_.AwaitUntil(clock_.Now() + kLong));
  std::array<std::byte, 2400> came{};
  const auto datagram = client_udp_.Receive(came);
  ASSERT_TRUE(datagram);
  EXPECT_TRUE(std::ranges::equal(datagram->bytes, sent));
}

TEST_F(ProxyUdpTest, StrangersAreNotListenedTo) {
  Start();
  Session session = OnConnect();
  fci::UdpSocket elsewhere(clock_, {kElsewhere, 0});
  fci::UdpSocket stranger(clock_, {kLoopback, 0});
  elsewhere.Send(Content(90), session.robot_side);  // before the robot was heard
  const fci::Endpoint client_side = ClientSide(session);
  stranger.Send(Content(91), session.robot_side);  // the robot's address, another port
  robot_udp_.Send(Content(1), session.robot_side);
  EXPECT_EQ(Await(client_udp_), 1u);
  elsewhere.Send(Content(92), client_side);
  stranger.Send(Content(93), client_side);
  client_udp_.Send(Content(2), client_side);
  EXPECT_EQ(Await(robot_udp_), 2u);
  End();
  const RelayCounts& counts = proxy_->counts().arm;
  EXPECT_EQ(counts.state, (DirectionCounts{.came = 2, .relayed = 2, .foreign = 1}));
  EXPECT_EQ(counts.command, (DirectionCounts{.came = 1, .relayed = 1}));
}

TEST_F(ProxyUdpTest, TheSameSeedDoesTheSameInEverySession) {
  constexpr std::uint64_t kCount = 60;
  config_.seed = 11;
  config_.state.loss = faults::LossModel(faults::IndependentLoss{0.3});
  config_.state.duplication = 0.3;
  faults::MessageFate fates(config_.state, config_.seed, faults::kStateStreams);
  std::vector<std::uint64_t> expected;
  for (std::uint64_t k = 0; k < kCount; ++k) {
    const faults::Fate fate = fates.Of(k);
    if (!fate.lost) expected.push_back(k);
    if (fate.duplicated) expected.push_back(k);
  }
  ASSERT_LT(expected.size(), 2 * kCount);
  Start();
  for (int round = 0; round < 2; ++round) {
    Session session = OnConnect();
    for (std::uint64_t k = 0; k < kCount; ++k) robot_udp_.Send(Content(k), session.robot_side);
    std::vector<std::uint64_t> came;
    while (came.size() < expected.size()) came.push_back(Await(client_udp_));
    EXPECT_EQ(came, expected);
    session.client.Close();
    AwaitEnd(session.robot);
  }
  End();
  EXPECT_EQ(proxy_->counts().arm.state.came, 2 * kCount);
  EXPECT_EQ(proxy_->counts().arm.state.relayed, 2 * expected.size());
}

TEST_F(ProxyUdpTest, EachDirectionHasItsOwnFaults) {
  config_.command.loss = faults::LossModel(faults::ScriptedLoss{{{1, 3}}});
  Start();
  const Session session = OnConnect();
  const fci::Endpoint client_side = ClientSide(session);
  for (std::uint64_t k = 0; k < 6; ++k) client_udp_.Send(Content(k), client_side);
  EXPECT_EQ(Await(robot_udp_), 0u);
  EXPECT_EQ(Await(robot_udp_), 4u);
  EXPECT_EQ(Await(robot_udp_), 5u);
  robot_udp_.Send(Content(7), session.robot_side);
  EXPECT_EQ(Await(client_udp_), 7u);
}

TEST_F(ProxyUdpTest, ADelayIsWaitedFor) {
  config_.state.delay = faults::DelayModel(faults::ConstantDelay{milliseconds(30)});
  Start();
  const Session session = OnConnect();
  const Time sent = clock_.Now();
  robot_udp_.Send(Content(1), session.robot_side);
  EXPECT_EQ(Await(client_udp_), 1u);
  // The kernel's stamp is of another clock, brought over to within a few microseconds.
  EXPECT_GE(clock_.Now() - sent, milliseconds(29));
}

TEST_F(ProxyUdpTest, TheHandsDatagramsAreLostApartFromTheArms) {
  constexpr std::uint64_t kCount = 60;
  config_.state.loss = faults::LossModel(faults::IndependentLoss{0.5});
  const auto bits = Random(config_.seed, RandomStream::kHandSeed).Bits(0);
  faults::MessageFate of_hand(config_.state, std::uint64_t{bits[1]} << 32 | bits[0],
                              faults::kStateStreams);
  faults::MessageFate of_arm(config_.state, config_.seed, faults::kStateStreams);
  std::vector<std::uint64_t> expected;
  bool differ = false;
  for (std::uint64_t k = 0; k < kCount; ++k) {
    const bool lost = of_hand.Of(k).lost;
    if (!lost) expected.push_back(k);
    differ = differ || lost != of_arm.Of(k).lost;
  }
  EXPECT_TRUE(differ);
  Start();
  fci::TcpStream client = fci::TcpStream::Connect(proxy_->hand(), kLong);
  Send(client, fci::EncodeRequest(0, fci::HandRequest(fci::Connect{3, client_udp_.local().port})));
  fci::TcpStream robot = AwaitConnection(robot_hand_);
  const Bytes connect = Receive(robot, 14);
  ASSERT_EQ(connect.size(), 14u);
  const auto port = static_cast<std::uint16_t>(std::to_integer<unsigned>(connect[12]) |
                                               std::to_integer<unsigned>(connect[13]) << 8);
  for (std::uint64_t k = 0; k < kCount; ++k) robot_udp_.Send(Content(k), {kLoopback, port});
  std::vector<std::uint64_t> came;
  while (came.size() < expected.size()) came.push_back(Await(client_udp_));
  EXPECT_EQ(came, expected);
}

TEST_F(ProxyUdpTest, NothingPassesOnceTheSessionHasEnded) {
  Start();
  Session first = OnConnect();
  const fci::Endpoint old_side = ClientSide(first);
  first.client.Close();
  EXPECT_EQ(AwaitEnd(first.robot), fci::StreamResult::kClosed);
  robot_udp_.Send(Content(5), first.robot_side);
  client_udp_.Send(Content(6), old_side);
  const Session second = OnConnect();
  robot_udp_.Send(Content(8), second.robot_side);
  EXPECT_EQ(Await(client_udp_), 8u);
}

}  // namespace
}  // namespace twin::proxy::proxy_udp_test
