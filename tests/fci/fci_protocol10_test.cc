// What protocol 10 has otherwise than protocol 5: numbers, sizes, precision, the end of a motion,
// the URDF. Offsets are reckoned here from the packed structures of libfranka 0.18 to 0.21.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/fci/arm_session.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"
#include "twin/fci/twin_sign.h"

namespace twin::fci::fci_protocol10_test {
namespace {

constexpr Protocol k10 = Protocol::k10;

template <typename T>
T At(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

Frame FrameOf(const std::vector<std::byte>& bytes) {
  const std::span<const std::byte> all(bytes);
  return {{At<std::uint32_t>(all, 0), At<std::uint32_t>(all, 4), At<std::uint32_t>(all, 8)},
          all.subspan(kArmHeadBytes)};
}

RobotState Sample() {
  RobotState state;
  state.message_id = 0x1'0000'0001;
  state.O_T_EE[12] = 0.306891;
  state.q = {0.1, -0.2, 0.3, -2.4, 0.5, 1.6, 0.7};
  state.accelerometer_top[0] = 1.25;
  state.accelerometer_bottom[17] = -9.81;
  state.motion_generator_mode = MotionGeneratorMode::kNone;
  state.controller_mode = ControllerMode::kExternalController;
  state.errors.set(3);
  state.reflex_reason.set(40);
  state.robot_mode = RobotMode::kMove;
  state.control_command_success_rate = 0.5;
  return state;
}

TEST(Protocol10Test, AStateHasItsFieldsAtTheirPlacesInSinglePrecision) {
  StateBytes buffer{};
  const auto bytes = Encode(k10, Sample(), buffer);
  ASSERT_EQ(bytes.size(), 1377u);
  EXPECT_EQ(At<std::uint64_t>(bytes, 0), 0x1'0000'0001u);
  EXPECT_EQ(At<float>(bytes, 8 + 4 * 12), 0.306891F);
  // Six poses, two bodies of 13 numbers, two elbows, then tau_J, tau_J_d, dtau_J before q.
  constexpr std::size_t kQ = 8 + 4 * (6 * 16 + 2 * 13 + 2 * 2 + 3 * 7);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_EQ(At<float>(bytes, kQ + 4 * i), static_cast<float>(Sample().q[i]));
  }
  constexpr std::size_t kModes = 1377 - 4 - 1 - 2 * 41 - 2;
  EXPECT_EQ(At<float>(bytes, kModes - 4 * 36), 1.25F);
  EXPECT_EQ(At<float>(bytes, kModes - 4), -9.81F);
  EXPECT_EQ(bytes[kModes], std::byte{5});
  EXPECT_EQ(bytes[kModes + 1], std::byte{2});
  EXPECT_EQ(bytes[kModes + 2 + 3], std::byte{1});
  EXPECT_EQ(bytes[kModes + 2 + 41 + 40], std::byte{1});
  EXPECT_EQ(bytes[kModes + 2 + 82], std::byte{2});
  EXPECT_EQ(At<float>(bytes, 1373), 0.5F);
}

TEST(Protocol10Test, AStateIsReadAsItWasWrittenUpToItsPrecision) {
  StateBytes buffer{};
  const auto bytes = Encode(k10, Sample(), buffer);
  RobotState read;
  ASSERT_EQ(Decode(k10, bytes, read), DatagramFault::kNone);
  EXPECT_EQ(read.message_id, Sample().message_id);
  EXPECT_EQ(read.motion_generator_mode, MotionGeneratorMode::kNone);
  EXPECT_EQ(read.errors, Sample().errors);
  EXPECT_NEAR(read.q[3], -2.4, 2.4e-7);
  EXPECT_EQ(Decode(k10, bytes.first(1376), read), DatagramFault::kSize);
  buffer[1377 - 4 - 1 - 82 - 2] = std::byte{6};
  EXPECT_EQ(Decode(k10, bytes, read), DatagramFault::kEnum);
}

TEST(Protocol10Test, NoTorqueAloneInAStateOfProtocol5) {
  StateBytes buffer{};
  Encode(Sample(), buffer);
  RobotState read;
  EXPECT_EQ(Decode(buffer, read), DatagramFault::kEnum);
}

TEST(Protocol10Test, EitherFlagOfACommandEndsItsMotion) {
  RobotCommand command;
  command.message_id = 7;
  command.q_c[6] = 0.7;
  AnyCommandBytes buffer{};
  ASSERT_EQ(Encode(k10, command, buffer).size(), 371u);
  for (const bool generator : {false, true}) {
    for (const bool torque : {false, true}) {
      buffer[313] = std::byte{generator};
      buffer[370] = std::byte{torque};
      RobotCommand read;
      ASSERT_EQ(Decode(k10, buffer, read), DatagramFault::kNone);
      EXPECT_EQ(read.motion_generation_finished, generator || torque);
      EXPECT_EQ(read.q_c, command.q_c);
    }
  }
  buffer[370] = std::byte{2};
  RobotCommand read;
  EXPECT_EQ(Decode(k10, buffer, read), DatagramFault::kBool);
  EXPECT_EQ(Decode(k10, std::span(buffer).first(370), read), DatagramFault::kSize);
  EXPECT_EQ(read.message_id, 0u) << "a refused datagram changes nothing";
}

TEST(Protocol10Test, RequestsHaveTheirNumbers) {
  constexpr std::array kInOrder{ArmCommand::kConnect,
                                ArmCommand::kMove,
                                ArmCommand::kStopMove,
                                ArmCommand::kSetCollisionBehavior,
                                ArmCommand::kSetJointImpedance,
                                ArmCommand::kSetCartesianImpedance,
                                ArmCommand::kSetGuidingMode,
                                ArmCommand::kSetEEToK,
                                ArmCommand::kSetNEToEE,
                                ArmCommand::kSetLoad,
                                ArmCommand::kAutomaticErrorRecovery,
                                ArmCommand::kGetRobotModel};
  for (std::uint32_t i = 0; i < kInOrder.size(); ++i) {
    EXPECT_EQ(NumberOf(k10, kInOrder[i]), i);
    EXPECT_EQ(ArmCommandAt(k10, i), kInOrder[i]);
  }
  EXPECT_EQ(ArmCommandAt(k10, 12), std::nullopt);
  for (const auto absent :
       {ArmCommand::kGetCartesianLimit, ArmCommand::kSetFilters, ArmCommand::kLoadModelLibrary}) {
    EXPECT_EQ(NumberOf(k10, absent), std::nullopt);
  }
  EXPECT_EQ(NumberOf(Protocol::k5, ArmCommand::kGetRobotModel), std::nullopt);
}

TEST(Protocol10Test, AMoveSaysWhetherItsCommandsAreGoals) {
  Move move;
  move.modes = {ControllerMode::kJointImpedance, MotionGeneratorMode::kJointPosition};
  move.asynchronous = true;
  move.maximum_velocity = {1, 2, 3, 4, 5, 6, 7};
  const auto bytes = EncodeRequest(9, move, k10);
  ASSERT_EQ(bytes.size(), kArmHeadBytes + 113);
  EXPECT_EQ(bytes[kArmHeadBytes + 56], std::byte{1});
  EXPECT_EQ(At<double>(bytes, kArmHeadBytes + 57 + 8 * 6), 7.0);
  const auto parsed = ParseArmRequest(FrameOf(bytes), k10);
  const auto* request = std::get_if<ArmRequest>(&parsed);
  ASSERT_NE(request, nullptr);
  EXPECT_TRUE(std::get<Move>(*request).asynchronous);
  EXPECT_EQ(std::get<Move>(*request).maximum_velocity, move.maximum_velocity);
  EXPECT_TRUE(std::holds_alternative<BadFrame>(ParseArmRequest(FrameOf(bytes))))
      << "protocol 5 has 56 bytes";
}

TEST(Protocol10Test, TorqueAloneIsAModeOfProtocol10) {
  Move move;
  move.modes = {ControllerMode::kExternalController, MotionGeneratorMode::kNone};
  for (const Protocol protocol : {Protocol::k5, k10}) {
    const auto bytes = EncodeRequest(1, move, protocol);
    EXPECT_EQ(At<std::uint32_t>(bytes, kArmHeadBytes + 4), 4u);
    const auto parsed = ParseArmRequest(FrameOf(bytes), protocol);
    EXPECT_EQ(std::get<Move>(std::get<ArmRequest>(parsed)).modes.generator,
              protocol == k10 ? MotionGeneratorMode::kNone : MotionGeneratorMode::kIdle);
  }
}

TEST(Protocol10Test, StatusesHaveTheirNumbers) {
  const auto number = [](ArmCommand command, auto status) {
    return StatusNumber(k10, command, static_cast<std::uint8_t>(status));
  };
  EXPECT_EQ(number(ArmCommand::kMove, MoveStatus::kPreempted), 2);
  EXPECT_EQ(number(ArmCommand::kMove, MoveStatus::kCommandNotPossibleRejected), 5);
  EXPECT_EQ(number(ArmCommand::kMove, MoveStatus::kReflexAborted), 8);
  EXPECT_EQ(number(ArmCommand::kMove, MoveStatus::kAborted), 11);
  EXPECT_EQ(number(ArmCommand::kAutomaticErrorRecovery,
                   RecoveryStatus::kManualErrorRecoveryRequiredRejected),
            3);
  EXPECT_EQ(number(ArmCommand::kSetLoad, SetterStatus::kInvalidArgumentRejected), 2);
  for (const ArmCommand command :
       {ArmCommand::kMove, ArmCommand::kStopMove, ArmCommand::kAutomaticErrorRecovery}) {
    const std::uint8_t count = command == ArmCommand::kMove       ? 10
                               : command == ArmCommand::kStopMove ? 5
                                                                  : 6;
    for (std::uint8_t status = 0; status < count; ++status) {
      EXPECT_EQ(TakeStatus(k10, command, StatusNumber(k10, command, status)), status);
    }
    EXPECT_EQ(TakeStatus(k10, command, 200), count) << "an unknown one stays unknown";
  }
  EXPECT_EQ(TakeStatus(k10, ArmCommand::kMove, 4),
            static_cast<std::uint8_t>(MoveStatus::kCommandNotPossibleRejected));
}

/// Grants everything.
class Robot final : public ArmService {
 public:
  MoveStatus Move(const fci::Move& asked) override {
    move = asked;
    return MoveStatus::kMotionStarted;
  }
  void StopMove() override {}
  SetterStatus Configure(const Setting&) override { return SetterStatus::kSuccess; }
  RecoveryStatus Recover() override { return RecoveryStatus::kSuccess; }
  SetterStatus CartesianLimitOf(std::int32_t, CartesianLimit&) override {
    return SetterStatus::kSuccess;
  }
  std::string_view RobotModel() override { return "<robot name=\"fr3\"/>"; }
  std::span<const std::byte> ModelLibrary(const LoadModelLibrary&) override { return {}; }
  ArmProgress Progress() override { return {}; }

  fci::Move move;
};

class Session10Test : public ::testing::Test {
 protected:
  std::optional<std::string> Send(const std::vector<std::byte>& bytes) {
    return session_.OnFrame(FrameOf(bytes));
  }
  std::string_view Text(std::size_t answer) const {
    const auto& bytes = answers_.at(answer);
    return {reinterpret_cast<const char*>(bytes.data()) + kArmHeadBytes + 1,
            bytes.size() - kArmHeadBytes - 1};
  }

  Robot robot_;
  std::vector<std::vector<std::byte>> answers_;
  ArmSession session_{robot_,
                      [this](std::span<const std::byte> bytes) {
                        answers_.emplace_back(bytes.begin(), bytes.end());
                      },
                      k10};
};

TEST_F(Session10Test, RefusesAClientOfProtocol5WithItsOwnVersion) {
  const auto why = Send(EncodeRequest(1, ArmRequest(Connect{5, 1000})));
  ASSERT_TRUE(why.has_value());
  EXPECT_THAT(*why, ::testing::HasSubstr("it speaks protocol 5; this robot speaks 10"));
  ASSERT_EQ(answers_.size(), 1u);
  EXPECT_EQ(answers_[0][kArmHeadBytes], std::byte{1});
  EXPECT_EQ(At<std::uint16_t>(answers_[0], kArmHeadBytes + 1), 10);
}

TEST_F(Session10Test, GivesTheRobotsModelAndAnswersInItsNumbers) {
  ASSERT_EQ(Send(EncodeRequest(1, ArmRequest(Connect{10, 1000}), k10)), std::nullopt);
  ASSERT_EQ(Send(EncodeRequest(2, GetRobotModel{}, k10)), std::nullopt);
  EXPECT_EQ(At<std::uint32_t>(answers_.at(1), 0), 11u);
  EXPECT_EQ(Text(1), robot_.RobotModel());
  ASSERT_EQ(Send(EncodeRequest(3, fci::Move{}, k10)), std::nullopt);
  session_.OnProgress({.mode = RobotMode::kReflex, .last_end = MoveStatus::kReflexAborted});
  ASSERT_EQ(answers_.size(), 4u);
  EXPECT_EQ(answers_[3][kArmHeadBytes], std::byte{8});
  const auto answer = ParseArmAnswer(ArmCommand::kMove, FrameOf(answers_[3]), k10);
  EXPECT_EQ(std::get<ArmAnswer>(answer).status,
            static_cast<std::uint8_t>(MoveStatus::kReflexAborted));
}

TEST(TwinSign10Test, StandsAtTheEndOfTheUrdf) {
  const std::string urdf = "<robot/>\n";
  EXPECT_EQ(TwinKindOf(urdf), TwinKind::kNone);
  EXPECT_EQ(TwinKindOf(urdf + std::string(kTwinComment)), TwinKind::kOnClock);
  EXPECT_EQ(TwinKindOf(urdf + std::string(kLockstepComment)), TwinKind::kInLockstep);
}

}  // namespace
}  // namespace twin::fci::fci_protocol10_test
