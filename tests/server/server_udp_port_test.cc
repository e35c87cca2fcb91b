#include "twin/server/udp_port.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::server::server_udp_port_test {
namespace {

constexpr std::uint32_t kLoopback = 0x7f000001;
constexpr Duration kLong = std::chrono::seconds(60);

class UdpPortTest : public ::testing::Test {
 protected:
  UdpPortTest() { port_.OnConnect(client_.local()); }

  static fci::CommandBytes Command(std::uint64_t answers) {
    RobotCommand command;
    command.message_id = answers;
    command.q_c[0] = 0.25;
    fci::CommandBytes bytes;
    fci::Encode(command, bytes);
    return bytes;
  }
  void ShowState(std::uint64_t id, RobotMode mode = RobotMode::kIdle) {
    RobotState state;
    state.message_id = id;
    state.robot_mode = mode;
    port_.Deliver(state);
  }
  /// What the port gives once something has come. On loopback a datagram is there when it is sent.
  std::optional<robot::ReceivedCommand> Receive() {
    robot::ReceivedCommand received;
    if (!port_.Receive(received)) return {};
    return received;
  }

  const MonotonicClock clock_;
  WakeEvent changed_;
  UdpPort port_{clock_, kLoopback, changed_};
  fci::UdpSocket client_{clock_, {kLoopback, 0}};
  fci::UdpSocket stranger_{clock_, {kLoopback, 0}};
};

TEST_F(UdpPortTest, StatesComeFromWhereCommandsGo) {
  ShowState(7);
  fci::StateBytes bytes;
  ASSERT_TRUE(client_.AwaitUntil(clock_.Now() + kLong));
  const auto datagram = client_.Receive(bytes);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->bytes.size(), fci::kStateBytes);
  EXPECT_EQ(datagram->from, port_.local());
  RobotState state;
  EXPECT_EQ(fci::Decode(datagram->bytes, state), fci::DatagramFault::kNone);
  EXPECT_EQ(state.message_id, 7u);
}

TEST_F(UdpPortTest, ACommandHasTheTimeItCame) {
  ShowState(7);
  const Time before = clock_.Now();
  ASSERT_TRUE(client_.Send(Command(7), port_.local()));
  ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
  const auto received = Receive();
  const Time after = clock_.Now();
  ASSERT_TRUE(received);
  EXPECT_EQ(received->command.message_id, 7u);
  EXPECT_EQ(received->command.q_c[0], 0.25);
  // The kernel's stamp is of another clock, brought over to within a few microseconds.
  EXPECT_GE(received->at, before - std::chrono::milliseconds(1));
  EXPECT_LE(received->at, after);
  EXPECT_FALSE(Receive());
}

TEST_F(UdpPortTest, OnlyTheSessionsClientIsHeard) {
  ShowState(7);
  ASSERT_TRUE(stranger_.Send(Command(7), port_.local()));
  ASSERT_TRUE(client_.Send(Command(6), port_.local()));
  ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
  const auto received = Receive();
  ASSERT_TRUE(received);
  EXPECT_EQ(received->command.message_id, 6u);
  EXPECT_EQ(port_.dropped(), (DroppedDatagrams{.foreign = 1}));
}

TEST_F(UdpPortTest, AFloodOfStrangersTakesNoRoomFromTheClient) {
  ShowState(7);
  for (int i = 0; i < 5000; ++i) {  // more than a socket holds
    ASSERT_TRUE(stranger_.Send(Command(7), port_.local()));
  }
  ASSERT_TRUE(client_.Send(Command(6), port_.local()));
  ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
  const auto received = Receive();
  ASSERT_TRUE(received) << "in one look";
  EXPECT_EQ(received->command.message_id, 6u);
  EXPECT_EQ(port_.dropped().foreign, 5000u);
}

TEST_F(UdpPortTest, TheNextClientIsHeardWhereverItComesFrom) {
  UdpPort everywhere(clock_, 0, changed_);  // 0.0.0.0
  robot::ReceivedCommand received;
  for (const std::uint32_t address : {kLoopback, kLoopback + 1, kLoopback}) {
    fci::UdpSocket client(clock_, {address, 0});
    everywhere.OnConnect(client.local());
    RobotState state;
    everywhere.Deliver(state);
    fci::StateBytes bytes;
    ASSERT_TRUE(client.AwaitUntil(clock_.Now() + kLong));
    const auto datagram = client.Receive(bytes);
    ASSERT_TRUE(datagram);
    ASSERT_TRUE(client.Send(Command(0), datagram->from));
    ASSERT_TRUE(everywhere.AwaitUntil(clock_.Now() + kLong));
    EXPECT_TRUE(everywhere.Receive(received));
    EXPECT_FALSE(everywhere.Receive(received));
    everywhere.Close();
  }
}

TEST_F(UdpPortTest, BetweenSessionsNothingGoesAndNothingComes) {
  port_.Close();
  ShowState(7);
  ASSERT_TRUE(client_.Send(Command(7), port_.local()));
  EXPECT_FALSE(Receive());
  EXPECT_EQ(port_.dropped(), (DroppedDatagrams{.foreign = 1}));
  fci::StateBytes bytes;
  EXPECT_FALSE(client_.Receive(bytes));
}

TEST_F(UdpPortTest, WhatIsNoCommandIsDroppedAndCounted) {
  ShowState(7);
  const fci::CommandBytes good = Command(7);
  std::vector<std::byte> longer(good.begin(), good.end());
  longer.push_back(std::byte{0});
  std::vector<std::byte> bad_flag(good.begin(), good.end());
  bad_flag[313] = std::byte{2};
  RobotCommand infinite;
  infinite.message_id = 7;
  infinite.tau_J_d[6] = std::numeric_limits<double>::infinity();
  fci::CommandBytes not_finite;
  fci::Encode(infinite, not_finite);
  ASSERT_TRUE(client_.Send(std::span(good).first(fci::kCommandBytes - 1), port_.local()));
  ASSERT_TRUE(client_.Send(longer, port_.local()));
  ASSERT_TRUE(client_.Send(std::span(good).first(0), port_.local()));
  ASSERT_TRUE(client_.Send(bad_flag, port_.local()));
  ASSERT_TRUE(client_.Send(not_finite, port_.local()));
  ASSERT_TRUE(client_.Send(Command(8), port_.local()));
  ASSERT_TRUE(client_.Send(Command(std::numeric_limits<std::uint64_t>::max()), port_.local()));
  ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
  EXPECT_FALSE(Receive());
  EXPECT_EQ(port_.dropped(), (DroppedDatagrams{.malformed = 5, .early = 2}));
}

TEST_F(UdpPortTest, AFloodIsLookedAtInPieces) {
  ShowState(7);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(client_.Send(Command(8), port_.local()));
  ASSERT_TRUE(client_.Send(Command(7), port_.local()));
  ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
  EXPECT_FALSE(Receive());
  EXPECT_EQ(port_.dropped().early, 64u);
  EXPECT_TRUE(Receive());
  EXPECT_EQ(port_.dropped().early, 100u);
}

TEST_F(UdpPortTest, ATenfoldFloodDelaysNoCommandHoweverLongItLasts) {
  constexpr std::size_t kTimes = 10;
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    const fci::CommandBytes command = Command(id);
    ShowState(id);
    for (std::size_t i = 0; i < kTimes; ++i) {
      ASSERT_TRUE(stranger_.Send(command, port_.local()));
      ASSERT_TRUE(client_.Send(std::span(command).first(i), port_.local()));
    }
    ASSERT_TRUE(client_.Send(command, port_.local()));
    ASSERT_TRUE(port_.AwaitUntil(clock_.Now() + kLong));
    const auto received = Receive();
    ASSERT_TRUE(received) << id;
    EXPECT_EQ(received->command.message_id, id);
    EXPECT_FALSE(Receive());
    EXPECT_EQ(port_.dropped(),
              (DroppedDatagrams{.foreign = kTimes * id, .malformed = kTimes * id}));
  }
}

TEST_F(UdpPortTest, TheBellRingsWhenTheModeChangesAndOnlyThen) {
  ShowState(1, RobotMode::kIdle);
  EXPECT_TRUE(changed_.Clear());
  ShowState(2, RobotMode::kIdle);
  EXPECT_FALSE(changed_.Clear());
  ShowState(3, RobotMode::kMove);
  ShowState(4, RobotMode::kReflex);
  EXPECT_TRUE(changed_.Clear());
  EXPECT_FALSE(changed_.Clear());
}

TEST_F(UdpPortTest, ItsRobotsEndAllocatesAndLocksNothing) {
  robot::ReceivedCommand received;
  const fci::CommandBytes malformed{};
  std::array<std::byte, 4096> waste;
  int taken = 0;
  const test::RealtimeGuard guard;
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    ShowState(id, id % 10 == 0 ? RobotMode::kMove : RobotMode::kIdle);
    static_cast<void>(client_.Receive(waste));
    client_.Send(Command(id), port_.local());
    stranger_.Send(Command(id), port_.local());
    client_.Send(std::span(malformed).first(3), port_.local());
    static_cast<void>(port_.AwaitUntil(clock_.Now()));
    while (port_.Receive(received)) ++taken;
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(taken, 1000);
}

}  // namespace
}  // namespace twin::server::server_udp_port_test
