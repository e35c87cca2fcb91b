#include "twin/fci/transcript.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "twin/core/random.h"
#include "twin/fci/capture.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/requests.h"
#include "twin/record/pcapng_reader.h"

namespace twin::fci::fci_transcript_test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr record::PacketEnd kArm{.address = 0x7f000001, .port = 1337};
constexpr record::PacketEnd kHand{.address = 0x7f000001, .port = 1338};
constexpr record::PacketEnd kClient{.address = 0x7f000001, .port = 40000};

record::Packet Stream(std::span<const std::byte> bytes, record::PacketEnd from,
                      record::PacketEnd to) {
  return {.at = Time(Duration(12'000'000'034)),
          .transport = record::Transport::kTcp,
          .from = from,
          .to = to,
          .bytes = bytes};
}

TEST(TranscriptTest, TellsEveryFieldOfAState) {
  RobotState state;
  state.message_id = 77;
  state.q = {0.1, -0.785, 0, -2.356, 0, 1.571, 1e-300};
  state.robot_mode = RobotMode::kReflex;
  state.reflex_reason.set(static_cast<std::size_t>(RobotError::kCartesianReflex));
  StateBytes bytes;
  Encode(state, bytes);
  Transcript transcript({});
  const std::string text = transcript.Take({.from = kArm, .to = kClient, .bytes = bytes});
  EXPECT_THAT(text,
              StartsWith("0.000000000 s  127.0.0.1:1337 > 127.0.0.1:40000  state 77: Reflex"));
  EXPECT_THAT(text, HasSubstr("\n    q = 0.1 -0.785 0 -2.356 0 1.571 1e-300\n"));
  EXPECT_THAT(text, HasSubstr("\n    errors = none\n    reflex_reason = cartesian_reflex\n"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 1 + 46) << "a line for each field of the protocol";
}

TEST(TranscriptTest, TellsARequestAndItsAnswersByTheirId) {
  Transcript transcript({});
  const auto move = EncodeRequest(7, ArmRequest(Move()));
  const std::string asked = transcript.Take(Stream(move, kClient, kArm));
  EXPECT_THAT(asked, StartsWith("12.000000034 s  "));
  EXPECT_THAT(asked, HasSubstr("request 7: Move\n    modes = joint_impedance joint_position\n"
                               "    maximum_path_deviation = 10 3.12 6.283185307179586\n"));
  for (const auto& [status, name] :
       {std::pair{1, "1 (motion_started)"}, std::pair{6, "6 (reflex_aborted)"}}) {
    const auto answer = EncodeArmAnswer(ArmCommand::kMove, 7, static_cast<std::uint8_t>(status));
    EXPECT_THAT(transcript.Take(Stream(answer, kArm, kClient)),
                EndsWith(std::string("answer 7: Move\n    status = ") + name + "\n"));
  }
  const auto unknown = EncodeArmAnswer(ArmCommand::kMove, 9, 0);
  EXPECT_THAT(transcript.Take(Stream(unknown, kArm, kClient)),
              HasSubstr("answer 9: its request was not captured"));
}

TEST(TranscriptTest, PutsFramesTogetherFromSegmentsOfAnySize) {
  std::vector<std::byte> all;
  for (const ArmRequest& request :
       {ArmRequest(Connect{.version = 5, .udp_port = 43210}),
        ArmRequest(Setting(setting::JointImpedance())), ArmRequest(StopMove{})}) {
    const auto frame = EncodeRequest(static_cast<std::uint32_t>(request.index()), request);
    all.insert(all.end(), frame.begin(), frame.end());
  }
  Transcript whole({});
  const std::string expected = whole.Take(Stream(all, kClient, kArm));
  EXPECT_THAT(expected, HasSubstr("    udp_port = 43210\n"));
  EXPECT_THAT(expected, HasSubstr("Set Joint Impedance\n    K_theta = 3000 3000 3000 2500"));
  for (std::size_t size : {1U, 7U, 50U}) {
    Transcript transcript({});
    std::string text;
    for (std::size_t at = 0; at < all.size(); at += size) {
      const auto part = std::span(all).subspan(at, std::min(size, all.size() - at));
      text += transcript.Take(Stream(part, kClient, kArm));
    }
    EXPECT_EQ(text, expected) << size << " bytes at a time";
  }
}

TEST(TranscriptTest, TellsTheHand) {
  Transcript transcript({.fields = false});
  const auto grasp = EncodeRequest(3, HandRequest(HandCommand(hand::Grasp{})));
  EXPECT_THAT(transcript.Take(Stream(grasp, kClient, kHand)), EndsWith("request 3: Grasp\n"));
  const auto answer = EncodeHandAnswer(HandCommandId::kGrasp, 3, HandResult::kUnsuccessful);
  EXPECT_THAT(transcript.Take(Stream(answer, kHand, kClient)), EndsWith("answer 3: Grasp\n"));
  HandStateBytes bytes;
  Encode(HandState{.message_id = 5, .width = 0.03, .is_grasped = true}, bytes);
  EXPECT_THAT(transcript.Take({.from = kHand, .to = kClient, .bytes = bytes}),
              EndsWith("hand state 5: 0.03 m, holds an object\n"));
}

TEST(TranscriptTest, TellsTheVacuumGripper) {
  constexpr record::PacketEnd kVacuum{.address = 0x7f000001, .port = 1339};
  Transcript transcript({});
  const auto suck = EncodeVacuumRequest(
      3, HandRequest(HandCommand(hand::Vacuum{.vacuum = 60, .profile = 1, .timeout_ms = 500})));
  EXPECT_THAT(transcript.Take(Stream(suck, kClient, kVacuum)),
              EndsWith("request 3: Vacuum\n    vacuum = 60\n    profile = 1\n"
                       "    timeout_ms = 500\n"));
  const auto answer = EncodeHandAnswer(HandCommandId{1}, 3, HandResult::kUnsuccessful);
  EXPECT_THAT(transcript.Take(Stream(answer, kVacuum, kClient)),
              EndsWith("answer 3: Vacuum\n    status = unsuccessful\n"));
  VacuumStateBytes bytes;
  Encode(VacuumState{.message_id = 5, .part_present = true, .vacuum = 600}, bytes);
  const std::string text = transcript.Take({.from = kVacuum, .to = kClient, .bytes = bytes});
  EXPECT_THAT(text, HasSubstr("vacuum state 5: 600 mbar, holds an object\n"));
  EXPECT_THAT(text, HasSubstr("    device_status = green\n"));
}

TEST(TranscriptTest, SaysWhatIsWrongWithBytesThatAreNone) {
  Transcript transcript({});
  StateBytes state;
  Encode(RobotState(), state);
  state[2280] = std::byte{9};
  EXPECT_THAT(transcript.Take({.from = kArm, .to = kClient, .bytes = state}),
              HasSubstr("datagram of 2373 bytes, damaged: enum"));
  EXPECT_THAT(transcript.Take({.from = kArm, .to = kClient, .bytes = std::span(state).first(99)}),
              HasSubstr("datagram of 99 bytes: none of the protocol"));
  const std::vector<std::byte> junk(40, std::byte{0xff});
  EXPECT_THAT(transcript.Take(Stream(junk, kClient, kArm)), HasSubstr("none of the protocol"));
  EXPECT_THAT(transcript.Take(Stream(junk, kClient, kArm)), IsEmpty()) << "said once";
}

TEST(TranscriptTest, CountsTheTcpPacketsBetweenOtherPorts) {
  Transcript transcript({.arm_port = 4242, .hand_port = 4243});
  const auto move = EncodeRequest(7, ArmRequest(Move()));
  EXPECT_THAT(transcript.Take(Stream(move, kClient, kArm)), HasSubstr("between other ports"));
  static_cast<void>(transcript.Take(Stream(move, kArm, kClient)));
  EXPECT_EQ(transcript.elsewhere(), 2U);
  static_cast<void>(transcript.Take(Stream(move, kClient, {.address = 0x7f000001, .port = 4242})));
  EXPECT_EQ(transcript.elsewhere(), 2U);
}

TEST(TranscriptTest, NeverFailsWhateverThePacketsHold) {
  const Random random(20261121, RandomStream::kTest);
  Transcript transcript({});
  const auto frame = EncodeRequest(1, ArmRequest(Setting(setting::Load())));
  for (std::uint64_t round = 0; round < 2000; ++round) {
    std::uint32_t draw = 0;
    const auto below = [&](std::size_t bound) {
      return static_cast<std::size_t>(random.Uniform(round, draw++) * static_cast<double>(bound));
    };
    std::vector<std::byte> bytes = frame;
    for (int i = 0; i < 3; ++i) bytes[below(bytes.size())] = std::byte(below(256));
    bytes.resize(below(bytes.size() + 1));
    record::PacketEnd client = kClient;
    client.port = static_cast<std::uint16_t>(below(50) + 2000);
    const bool asks = below(2) == 0;
    record::Packet packet = Stream(bytes, asks ? client : kArm, asks ? kArm : client);
    if (below(4) == 0) packet.transport = record::Transport::kUdp;
    static_cast<void>(transcript.Take(packet));
  }
}

TEST(CaptureTest, KeepsDatagramsAndStreamsInOrderOfTheirTime) {
  const record::TemporaryFolder folder;
  const auto path = folder / "session.pcapng";
  constexpr int kStates = 500;
  Capture capture(path);
  StateBytes bytes;
  for (int i = 0; i < kStates; ++i) {
    RobotState state;
    state.message_id = static_cast<std::uint64_t>(i);
    Encode(state, bytes);
    capture.PutRealtime({.at = Time(Duration(i)), .from = kArm, .to = kClient, .bytes = bytes});
  }
  const auto request = EncodeRequest(0, ArmRequest(StopMove{}));
  capture.Put(Stream(request, kClient, kArm));
  EXPECT_EQ(capture.Finish(), 0u);

  record::PcapngReader reader(path);
  Transcript transcript({.fields = false});
  int packets = 0;
  std::string last;
  while (const auto packet = reader.Next()) {
    if (packets < kStates) {
      EXPECT_EQ(packet->at, Time(Duration(packets)));
    }
    ++packets;
    last = transcript.Take(*packet);
  }
  EXPECT_EQ(packets, kStates + 1);
  EXPECT_THAT(last, EndsWith("request 0: Stop Move\n"));
}

}  // namespace
}  // namespace twin::fci::fci_transcript_test
