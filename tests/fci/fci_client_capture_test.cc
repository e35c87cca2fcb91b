// What a client's capture holds.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "fci/fake_robot.h"
#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/fci/arm_client.h"
#include "twin/fci/capture.h"
#include "twin/fci/hand_client.h"
#include "twin/record/pcapng_reader.h"

namespace twin::fci::fci_client_capture_test {
namespace {

using test::FakeRobot;
using Bytes = std::vector<std::byte>;

/// A packet with bytes of its own.
struct Kept {
  record::Packet packet;
  Bytes bytes;
};

class ClientCaptureTest : public ::testing::Test {
 protected:
  /// Completes the file. @pre the client is gone.
  std::vector<Kept> Read() {
    EXPECT_EQ(capture_.Finish(), 0u);
    std::vector<Kept> all;
    record::PcapngReader reader(path_);
    while (const auto packet = reader.Next()) {
      all.push_back({*packet, {packet->bytes.begin(), packet->bytes.end()}});
    }
    return all;
  }
  static void AwaitState(ArmClient& client, const MonotonicClock& clock, RobotState& state) {
    Time at{};
    while (client.Receive(state, at) == ReceiveResult::kPending) {
      static_cast<void>(client.arrival().AwaitUntil(clock.Now() + std::chrono::seconds(1)));
    }
  }

  test::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "client.pcapng";
  Capture capture_{path_};
  MonotonicClock clock_;
};

TEST_F(ClientCaptureTest, HoldsWhatTheArmsClientSendsAndReceivesByteForByte) {
  FakeRobot robot(HeadKind::kArm, [](FakeRobot&, const Frame& request) {
    return EncodeArmAnswer(ArmCommand::kStopMove, request.head.command_id, 0);
  });
  RobotState state;
  RobotCommand command;
  CommandBytes sent{};
  {
    ArmClient client(clock_, "127.0.0.1", robot.port(), {}, &capture_);
    robot.SendStateId(41);
    AwaitState(client, clock_, state);
    command.message_id = 41;
    client.Send(command);
    Encode(command, sent);
    static_cast<void>(client.StopMove());
  }
  RobotState told;
  told.message_id = 41;
  StateBytes received{};
  Encode(told, received);
  const Endpoint server{FakeRobot::kHere, robot.port()};
  std::vector<std::pair<bool, Bytes>> tcp;  // whether to the robot
  std::vector<Bytes> udp;
  for (const Kept& kept : Read()) {
    if (kept.packet.transport == record::Transport::kUdp) {
      udp.push_back(kept.bytes);
      continue;
    }
    EXPECT_TRUE(kept.packet.to == server || kept.packet.from == server);
    tcp.emplace_back(kept.packet.to == server, kept.bytes);
  }
  EXPECT_EQ(udp,
            (std::vector<Bytes>{{received.begin(), received.end()}, {sent.begin(), sent.end()}}));
  ASSERT_EQ(tcp.size(), 4u);
  EXPECT_EQ(tcp[0].second.size(), 16u);
  EXPECT_EQ(tcp[1], std::pair(false, EncodeArmConnectAnswer(0, ConnectStatus::kSuccess,
                                                            VersionOf(Protocol::k5))));
  EXPECT_EQ(tcp[2], std::pair(true, EncodeRequest(1, ArmRequest(StopMove{}))));
  EXPECT_EQ(tcp[3], std::pair(false, EncodeArmAnswer(ArmCommand::kStopMove, 1, 0)));
}

TEST_F(ClientCaptureTest, HoldsStrangersDatagramsToo) {
  FakeRobot robot(HeadKind::kArm, [](FakeRobot&, const Frame&) { return Bytes(); });
  UdpSocket stranger(clock_, {FakeRobot::kElsewhere, 0});
  {
    RobotState state;
    ArmClient client(clock_, "127.0.0.1", robot.port(), {}, &capture_);
    robot.SendStateId(7, &stranger);
    robot.SendStateId(8);
    AwaitState(client, clock_, state);
  }
  bool is_there = false;
  for (const Kept& kept : Read()) is_there = is_there || kept.packet.from == stranger.local();
  EXPECT_TRUE(is_there);
}

TEST_F(ClientCaptureTest, HoldsWhatTheHandsClientSendsAndReceives) {
  FakeRobot robot(HeadKind::kHand, [](FakeRobot&, const Frame& request) {
    return EncodeHandAnswer(HandCommandId::kStop, request.head.command_id, HandResult::kSuccess);
  });
  HandState told;
  told.message_id = 3;
  HandStateBytes bytes{};
  Encode(told, bytes);
  {
    HandClient client("127.0.0.1", robot.port(), {}, &capture_);
    robot.SendDatagram(bytes);
    static_cast<void>(client.State());
    static_cast<void>(client.Start(hand::Stop{}));
  }
  std::vector<Bytes> all;
  for (const Kept& kept : Read()) all.push_back(kept.bytes);
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[2], Bytes(bytes.begin(), bytes.end()));
  EXPECT_EQ(all[4], EncodeHandAnswer(HandCommandId::kStop, 1, HandResult::kSuccess));
}

TEST_F(ClientCaptureTest, ItsTimeGoesOnWhenTheRunsClockIsRestarted) {
  FakeRobot robot(HeadKind::kArm, [](FakeRobot&, const Frame&) { return Bytes(); });
  const Time begin = capture_.clock().Now();
  {
    RobotState state;
    ArmClient client(clock_, "127.0.0.1", robot.port(), {}, &capture_);
    for (std::uint64_t id = 1; id <= 5; ++id) {
      rt::Pause(std::chrono::milliseconds(5));
      clock_.Restart();
      robot.SendStateId(id);
      AwaitState(client, clock_, state);
    }
  }
  const Time end = capture_.clock().Now();
  Time last = begin;
  for (const Kept& kept : Read()) {
    if (kept.packet.transport != record::Transport::kUdp) continue;
    // A stamp of the kernel's clock is brought over to within a few microseconds.
    EXPECT_GE(kept.packet.at, last + std::chrono::milliseconds(4));
    last = kept.packet.at;
  }
  EXPECT_GE(last, begin + std::chrono::milliseconds(20));
  EXPECT_LE(last, end);
}

TEST_F(ClientCaptureTest, AllocatesAndLocksNothingInTheTick) {
  FakeRobot robot(HeadKind::kArm, [](FakeRobot&, const Frame&) { return Bytes(); });
  ArmClient client(clock_, "127.0.0.1", robot.port(), {}, &capture_);
  RobotState sent;
  RobotState state;
  RobotCommand command;
  const test::RealtimeGuard guard;
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    sent.message_id = id;
    robot.SendState(sent);
    AwaitState(client, clock_, state);
    command.message_id = state.message_id;
    client.Send(command);
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::fci::fci_client_capture_test
