#include <gtest/gtest.h>

#include "fci/byte_packer.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"

// Frames as a client of the real robot and a server for it were seen to exchange.
namespace twin::fci::fci_golden_frames_test {
namespace {

const Bytes kMoveFrame =
    Hex("01000000 07000000 44000000 00000000 00000000"
        "0000000000002440 f6285c8fc2f50840 182d4454fb211940"
        "0000000000002440 f6285c8fc2f50840 182d4454fb211940");

/// The frame in `bytes`, of which it must be all there is. @post valid while `reader` lives.
Frame ReadOne(FrameReader& reader, const Bytes& bytes) {
  std::copy(bytes.begin(), bytes.end(), reader.Room().begin());
  reader.Received(bytes.size());
  const auto frame = reader.Next();
  EXPECT_TRUE(frame.has_value());
  EXPECT_FALSE(reader.is_inside_frame());
  return frame.value_or(Frame());
}

ArmRequest ReadArm(const Bytes& bytes) {
  FrameReader reader(HeadKind::kArm, kLargestArmRequest);
  const auto parsed = ParseArmRequest(ReadOne(reader, bytes));
  EXPECT_TRUE(std::holds_alternative<ArmRequest>(parsed));
  return std::holds_alternative<ArmRequest>(parsed) ? std::get<ArmRequest>(parsed) : ArmRequest();
}

TEST(GoldenFrameTest, IsConnect) {
  const Bytes frame = Hex("00000000 00000000 10000000 0500 caa8");
  EXPECT_EQ(EncodeRequest(0, ArmRequest(Connect{5, 43210})), frame);
  EXPECT_EQ(std::get<Connect>(ReadArm(frame)), (Connect{5, 43210}));
}

TEST(GoldenFrameTest, IsTheAnswerToConnect) {
  EXPECT_EQ(EncodeArmConnectAnswer(0, ConnectStatus::kSuccess, 5),
            Hex("00000000 00000000 0f000000 00 0500"));
  EXPECT_EQ(EncodeArmConnectAnswer(0, ConnectStatus::kIncompatibleLibraryVersion, 5),
            Hex("00000000 00000000 0f000000 01 0500"));
}

TEST(GoldenFrameTest, IsMove) {
  EXPECT_EQ(EncodeRequest(7, ArmRequest(Move())), kMoveFrame);
  const auto move = std::get<Move>(ReadArm(kMoveFrame));
  EXPECT_EQ(move.modes.controller, ControllerMode::kJointImpedance);
  EXPECT_EQ(move.modes.generator, MotionGeneratorMode::kJointPosition);
  EXPECT_EQ(move.maximum_path_deviation, Deviation());
  EXPECT_EQ(move.maximum_goal_pose_deviation, Deviation());
}

TEST(GoldenFrameTest, IsTheAnswerToMove) {
  const auto answer = [](MoveStatus status) {
    return EncodeArmAnswer(ArmCommand::kMove, 7, static_cast<std::uint8_t>(status));
  };
  EXPECT_EQ(answer(MoveStatus::kMotionStarted), Hex("01000000 07000000 0d000000 01"));
  EXPECT_EQ(answer(MoveStatus::kSuccess), Hex("01000000 07000000 0d000000 00"));
}

TEST(GoldenFrameTest, IsStopMoveAndItsAnswer) {
  const Bytes frame = Hex("02000000 08000000 0c000000");
  EXPECT_EQ(EncodeRequest(8, ArmRequest(StopMove())), frame);
  EXPECT_TRUE(std::holds_alternative<StopMove>(ReadArm(frame)));
  EXPECT_EQ(EncodeArmAnswer(ArmCommand::kStopMove, 8, 0), Hex("02000000 08000000 0d000000 00"));
}

TEST(GoldenFrameTest, IsLoadModelLibrary) {
  const Bytes frame = Hex("0d000000 09000000 0e000000 00 00");
  EXPECT_EQ(EncodeRequest(9, ArmRequest(LoadModelLibrary())), frame);
  const auto machine = std::get<LoadModelLibrary>(ReadArm(frame));
  EXPECT_EQ(machine.architecture, Architecture::kX64);
  EXPECT_EQ(machine.system, OperatingSystem::kLinux);
}

TEST(GoldenFrameTest, IsTheHandsConnectAndItsAnswer) {
  const Bytes frame = Hex("0000 00000000 0e000000 0300 caa8");
  EXPECT_EQ(EncodeRequest(0, HandRequest(Connect{3, 43210})), frame);
  FrameReader reader(HeadKind::kHand, kLargestHandRequest);
  const auto parsed = ParseHandRequest(ReadOne(reader, frame));
  ASSERT_TRUE(std::holds_alternative<HandRequest>(parsed));
  EXPECT_EQ(std::get<Connect>(std::get<HandRequest>(parsed)), (Connect{3, 43210}));
  EXPECT_EQ(EncodeHandConnectAnswer(0, ConnectStatus::kSuccess, 3),
            Hex("0000 00000000 0e000000 0000 0300"));
}

TEST(GoldenFrameTest, IsHomingAndItsAnswer) {
  EXPECT_EQ(EncodeRequest(1, HandRequest(HandCommand(hand::Homing()))),
            Hex("0100 01000000 0a000000"));
  EXPECT_EQ(EncodeHandAnswer(HandCommandId::kHoming, 1, HandResult::kSuccess),
            Hex("0100 01000000 0c000000 0000"));
}

}  // namespace
}  // namespace twin::fci::fci_golden_frames_test
