#include "twin/fci/arm_session.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/fci/frame_reader.h"

namespace twin::fci::fci_arm_session_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A robot that answers what it is told to.
class FakeArm final : public ArmService {
 public:
  MoveStatus Move(const fci::Move& move) override {
    asked.push_back("Move");
    modes = move.modes;
    if (move_status == MoveStatus::kMotionStarted) {
      progress = {RobotMode::kMove, true, MoveStatus::kMotionStarted};
    }
    return move_status;
  }
  void StopMove() override { asked.push_back("StopMove"); }
  SetterStatus Configure(const Setting& setting) override {
    asked.emplace_back(twin::Name(setting));
    return setter_status;
  }
  RecoveryStatus Recover() override {
    asked.push_back("Recover");
    if (recovers) progress.mode = RobotMode::kAutomaticErrorRecovery;
    return recovery_status;
  }
  SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit) override {
    limit.object_world_size[0] = id;
    return SetterStatus::kSuccess;
  }
  std::string_view RobotModel() override { return "<robot/>"; }
  std::span<const std::byte> ModelLibrary(const LoadModelLibrary&) override { return library; }
  ArmProgress Progress() override { return progress; }

  std::vector<std::string> asked;
  MotionModes modes;
  MoveStatus move_status = MoveStatus::kMotionStarted;
  SetterStatus setter_status = SetterStatus::kSuccess;
  RecoveryStatus recovery_status = RecoveryStatus::kSuccess;
  bool recovers = false;
  std::vector<std::byte> library;
  ArmProgress progress{RobotMode::kIdle, false, MoveStatus::kMotionStarted};
};

/// An answer as a client sees it: command, command_id, status.
struct Seen {
  std::uint32_t command = 0;
  std::uint32_t id = 0;
  int status = 0;
  bool operator==(const Seen&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Seen& seen) {
  return out << "{command " << seen.command << ", id " << seen.id << ", status " << seen.status
             << "}";
}

constexpr std::uint32_t kMove = 1;
constexpr std::uint32_t kStopMove = 2;
constexpr std::uint32_t kSetJointImpedance = 5;
constexpr std::uint32_t kRecovery = 12;

class ArmSessionTest : public ::testing::Test {
 protected:
  ArmSessionTest()
      : session_(arm_, [this](std::span<const std::byte> bytes) {
          frames_.emplace_back(bytes.begin(), bytes.end());
        }) {}

  /// @returns why the connection is to be closed.
  std::optional<std::string> Send(const std::vector<std::byte>& frame) {
    FrameReader reader(HeadKind::kArm, 4096);
    std::ranges::copy(frame, reader.Room().begin());
    reader.Received(frame.size());
    return session_.OnFrame(*reader.Next());
  }
  std::optional<std::string> Ask(std::uint32_t id, const ArmRequest& request) {
    return Send(EncodeRequest(id, request));
  }
  void ConnectIt() {
    ASSERT_EQ(Ask(0, Connect{5, 43210}), std::nullopt);
    frames_.clear();
  }
  void StartMotion(std::uint32_t id) {
    ASSERT_EQ(Ask(id, Move{}), std::nullopt);
    ASSERT_THAT(TakeSeen(), ElementsAre(Seen{kMove, id, 1}));
  }
  void EndMotion(MoveStatus end, RobotMode mode = RobotMode::kIdle) {
    arm_.progress = {mode, false, end};
    session_.OnProgress(arm_.progress);
  }
  /// The answers since the last call.
  std::vector<Seen> TakeSeen() {
    std::vector<Seen> seen;
    for (const auto& frame : std::exchange(frames_, {})) {
      const auto word = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 4; i > 0; --i) {
          value = value << 8 | std::to_integer<std::uint32_t>(frame[at + i - 1]);
        }
        return value;
      };
      EXPECT_EQ(word(8), frame.size());
      seen.push_back({word(0), word(4), std::to_integer<int>(frame[12])});
    }
    return seen;
  }

  FakeArm arm_;
  std::vector<std::vector<std::byte>> frames_;
  ArmSession session_;
};

TEST_F(ArmSessionTest, ConnectIsAnsweredWithOurVersionAndOpensTheSession) {
  EXPECT_EQ(session_.udp_port(), std::nullopt);
  EXPECT_EQ(Ask(0, Connect{5, 43210}), std::nullopt);
  EXPECT_EQ(session_.udp_port(), 43210);
  // Connect response, success, version 5, as the protocol's description writes it.
  const std::array<int, 15> golden{0, 0, 0, 0, 0, 0, 0, 0, 15, 0, 0, 0, 0, 5, 0};
  ASSERT_EQ(frames_.size(), 1u);
  ASSERT_EQ(frames_[0].size(), golden.size());
  for (std::size_t i = 0; i < golden.size(); ++i) {
    EXPECT_EQ(std::to_integer<int>(frames_[0][i]), golden[i]) << "byte " << i;
  }
}

TEST_F(ArmSessionTest, AnotherVersionIsToldOursAndSentAway) {
  for (const std::uint16_t version : {0, 4, 6, 65535}) {
    const auto why = Ask(0, Connect{version, 43210});
    ASSERT_TRUE(why);
    EXPECT_THAT(*why, HasSubstr(std::to_string(version)));
    EXPECT_EQ(session_.udp_port(), std::nullopt);
    ASSERT_EQ(frames_.size(), 1u);
    EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 1);
    EXPECT_EQ(std::to_integer<int>(frames_[0][13]), 5);
    frames_.clear();
  }
}

TEST_F(ArmSessionTest, ClosesAConnectionThatDoesNotBeginWithConnect) {
  for (const ArmRequest& request :
       {ArmRequest(Move{}), ArmRequest(StopMove{}), ArmRequest(GetCartesianLimit{}),
        ArmRequest(Setting(setting::Load{})), ArmRequest(AutomaticErrorRecovery{}),
        ArmRequest(LoadModelLibrary{})}) {
    const auto why = Ask(0, request);
    ASSERT_TRUE(why);
    EXPECT_THAT(*why, HasSubstr("before Connect"));
  }
  EXPECT_THAT(frames_, IsEmpty());
  EXPECT_THAT(arm_.asked, IsEmpty());
}

TEST_F(ArmSessionTest, ClosesAConnectionThatConnectsTwiceOrNowhere) {
  EXPECT_NE(Ask(0, Connect{5, 0}), std::nullopt);
  ConnectIt();
  EXPECT_NE(Ask(1, Connect{5, 43210}), std::nullopt);
}

TEST_F(ArmSessionTest, ClosesAConnectionWithAFrameThatIsNone) {
  ConnectIt();
  for (std::uint32_t command : {14u, 255u, 0xffffffffu}) {
    std::vector<std::byte> frame = EncodeRequest(1, ArmRequest(StopMove{}));
    for (std::size_t i = 0; i < 4; ++i) frame[i] = std::byte(command >> (8 * i) & 0xff);
    EXPECT_NE(Send(frame), std::nullopt) << command;
  }
  std::vector<std::byte> short_move = EncodeRequest(1, ArmRequest(Move{}));
  short_move.pop_back();
  short_move[8] = std::byte(short_move.size());
  EXPECT_NE(Send(short_move), std::nullopt);
}

TEST_F(ArmSessionTest, AMotionIsAnsweredWhenItStartsAndWhenItEnds) {
  ConnectIt();
  std::uint32_t id = 0;
  for (const MoveStatus end :
       {MoveStatus::kSuccess, MoveStatus::kPreempted, MoveStatus::kReflexAborted,
        MoveStatus::kEmergencyAborted, MoveStatus::kInputErrorAborted, MoveStatus::kAborted}) {
    EXPECT_FALSE(session_.has_pending());
    StartMotion(++id);
    EXPECT_TRUE(session_.has_pending());
    session_.OnProgress(arm_.progress);
    EXPECT_THAT(TakeSeen(), IsEmpty());
    EndMotion(end);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, id, static_cast<int>(end)}));
    EndMotion(end);
    EXPECT_THAT(TakeSeen(), IsEmpty());
  }
}

TEST_F(ArmSessionTest, AMovesModesReachTheRobot) {
  ConnectIt();
  Move move;
  move.modes = {ControllerMode::kExternalController, MotionGeneratorMode::kCartesianVelocity};
  EXPECT_EQ(Ask(1, move), std::nullopt);
  EXPECT_EQ(arm_.modes.controller, ControllerMode::kExternalController);
  EXPECT_EQ(arm_.modes.generator, MotionGeneratorMode::kCartesianVelocity);
}

TEST_F(ArmSessionTest, ARejectedMoveIsAnsweredOnce) {
  ConnectIt();
  std::uint32_t id = 1;
  for (const MoveStatus status :
       {MoveStatus::kCommandNotPossibleRejected, MoveStatus::kStartAtSingularPoseRejected,
        MoveStatus::kInvalidArgumentRejected}) {
    arm_.move_status = status;
    EXPECT_EQ(Ask(++id, Move{}), std::nullopt);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, id, static_cast<int>(status)}));
    session_.OnProgress({RobotMode::kIdle, false, MoveStatus::kSuccess});
    EXPECT_THAT(TakeSeen(), IsEmpty());
    EXPECT_FALSE(session_.has_pending());
  }
}

TEST_F(ArmSessionTest, ASecondMoveIsForTheRobotToReject) {
  ConnectIt();
  StartMotion(3);
  arm_.move_status = MoveStatus::kCommandNotPossibleRejected;
  EXPECT_EQ(Ask(4, Move{}), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 4, 3}));
  EndMotion(MoveStatus::kSuccess);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 3, 0}));
}

TEST_F(ArmSessionTest, AMoveRightBehindAnEndThatWasNotToldYetFindsItTold) {
  ConnectIt();
  StartMotion(1);
  arm_.progress = {RobotMode::kIdle, false, MoveStatus::kSuccess};
  EXPECT_EQ(Ask(2, Move{}), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 1, 0}, Seen{kMove, 2, 1}));
  EndMotion(MoveStatus::kPreempted);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 2, 2}));
}

TEST_F(ArmSessionTest, StopMoveIsAnsweredJustBeforeTheMotionItEnds) {
  ConnectIt();
  StartMotion(1);
  EXPECT_EQ(Ask(2, StopMove{}), std::nullopt);
  EXPECT_THAT(arm_.asked, ElementsAre("Move", "StopMove"));
  session_.OnProgress(arm_.progress);  // it still decelerates
  EXPECT_THAT(TakeSeen(), IsEmpty());
  EXPECT_TRUE(session_.has_pending());
  EndMotion(MoveStatus::kPreempted);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kStopMove, 2, 0}, Seen{kMove, 1, 2}));
  EXPECT_FALSE(session_.has_pending());
}

TEST_F(ArmSessionTest, TheTwoStopMovesOfOneStopAreBothSuccesses) {
  ConnectIt();
  StartMotion(1);
  EXPECT_EQ(Ask(2, StopMove{}), std::nullopt);
  EndMotion(MoveStatus::kPreempted);
  EXPECT_EQ(Ask(3, StopMove{}), std::nullopt);  // of the loop's own cancelling
  EXPECT_THAT(TakeSeen(),
              ElementsAre(Seen{kStopMove, 2, 0}, Seen{kMove, 1, 2}, Seen{kStopMove, 3, 0}));
}

TEST_F(ArmSessionTest, TwoStopMovesDuringOneDecelerationAreBothSuccesses) {
  ConnectIt();
  StartMotion(1);
  EXPECT_EQ(Ask(2, StopMove{}), std::nullopt);
  EXPECT_EQ(Ask(3, StopMove{}), std::nullopt);
  EndMotion(MoveStatus::kPreempted);
  EXPECT_THAT(TakeSeen(),
              ElementsAre(Seen{kStopMove, 2, 0}, Seen{kStopMove, 3, 0}, Seen{kMove, 1, 2}));
}

TEST_F(ArmSessionTest, StopMoveWithoutAMotionIsASuccessInEveryMode) {
  ConnectIt();
  std::uint32_t id = 0;
  for (int mode = 0; mode <= 6; ++mode) {
    arm_.progress.mode = static_cast<RobotMode>(mode);
    EXPECT_EQ(Ask(++id, StopMove{}), std::nullopt);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kStopMove, id, 0}));
  }
  EXPECT_THAT(arm_.asked, IsEmpty());
}

TEST_F(ArmSessionTest, StopMoveIsASuccessWhenAReflexEndsTheMotionFirst) {
  ConnectIt();
  StartMotion(1);
  EXPECT_EQ(Ask(2, StopMove{}), std::nullopt);
  EndMotion(MoveStatus::kReflexAborted, RobotMode::kReflex);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kStopMove, 2, 0}, Seen{kMove, 1, 6}));
}

TEST_F(ArmSessionTest, AUserStopEndsTheMotionWithEmergencyAborted) {
  ConnectIt();
  StartMotion(1);
  EndMotion(MoveStatus::kEmergencyAborted, RobotMode::kUserStopped);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kMove, 1, 7}));
}

TEST_F(ArmSessionTest, StopMovesWithoutEndCloseTheConnection) {
  ConnectIt();
  StartMotion(1);
  std::uint32_t taken = 0;
  while (taken < 1000 && !Ask(2 + taken, StopMove{})) ++taken;
  EXPECT_EQ(taken, 64u);
}

TEST_F(ArmSessionTest, SettersHaveTheRobotsAnswer) {
  ConnectIt();
  std::uint32_t id = 0;
  for (const SetterStatus status :
       {SetterStatus::kSuccess, SetterStatus::kCommandNotPossibleRejected,
        SetterStatus::kInvalidArgumentRejected}) {
    arm_.setter_status = status;
    EXPECT_EQ(Ask(++id, Setting(setting::JointImpedance{})), std::nullopt);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kSetJointImpedance, id, static_cast<int>(status)}));
  }
}

TEST_F(ArmSessionTest, SettersWhileMovingAreAnsweredAtOnce) {
  ConnectIt();
  StartMotion(1);
  arm_.setter_status = SetterStatus::kCommandNotPossibleRejected;
  EXPECT_EQ(Ask(2, Setting(setting::JointImpedance{})), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kSetJointImpedance, 2, 1}));
  EXPECT_TRUE(session_.has_pending());
}

TEST_F(ArmSessionTest, RecoveryIsAnsweredWhenItIsOver) {
  ConnectIt();
  arm_.recovers = true;
  const std::vector<std::pair<RobotMode, int>> ends{
      {RobotMode::kIdle, 0}, {RobotMode::kReflex, 3}, {RobotMode::kUserStopped, 4}};
  std::uint32_t id = 0;
  for (const auto& [mode, status] : ends) {
    EXPECT_EQ(Ask(++id, AutomaticErrorRecovery{}), std::nullopt);
    session_.OnProgress(arm_.progress);
    EXPECT_THAT(TakeSeen(), IsEmpty());
    EXPECT_TRUE(session_.has_pending());
    session_.OnProgress({mode, false, MoveStatus::kReflexAborted});
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kRecovery, id, status}));
    EXPECT_FALSE(session_.has_pending());
  }
}

TEST_F(ArmSessionTest, RecoveryAfterAReflexBeginsWhenTheArmRests) {
  ConnectIt();
  StartMotion(1);
  EndMotion(MoveStatus::kReflexAborted, RobotMode::kReflex);
  TakeSeen();
  arm_.recovery_status = RecoveryStatus::kCommandNotPossibleRejected;
  EXPECT_EQ(Ask(2, AutomaticErrorRecovery{}), std::nullopt);
  for (int i = 0; i < 3; ++i) session_.OnProgress(arm_.progress);
  EXPECT_THAT(TakeSeen(), IsEmpty());
  EXPECT_TRUE(session_.has_pending());
  arm_.recovery_status = RecoveryStatus::kSuccess;
  arm_.recovers = true;
  session_.OnProgress(arm_.progress);
  EXPECT_EQ(arm_.progress.mode, RobotMode::kAutomaticErrorRecovery);
  EXPECT_THAT(TakeSeen(), IsEmpty());
  session_.OnProgress({RobotMode::kIdle, false, MoveStatus::kReflexAborted});
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kRecovery, 2, 0}));
  EXPECT_FALSE(session_.has_pending());
}

TEST_F(ArmSessionTest, RecoveryThatWaitsForTheArmIsAnsweredWhateverComes) {
  const std::vector<std::tuple<RecoveryStatus, RobotMode, int>> ends{
      {RecoveryStatus::kManualErrorRecoveryRequiredRejected, RobotMode::kReflex, 2},
      {RecoveryStatus::kCommandNotPossibleRejected, RobotMode::kUserStopped, 4}};
  ConnectIt();
  std::uint32_t id = 0;
  for (const auto& [then, mode, status] : ends) {
    arm_.progress.mode = RobotMode::kReflex;
    arm_.recovery_status = RecoveryStatus::kCommandNotPossibleRejected;
    EXPECT_EQ(Ask(++id, AutomaticErrorRecovery{}), std::nullopt);
    EXPECT_THAT(TakeSeen(), IsEmpty());
    arm_.recovery_status = then;
    arm_.progress.mode = mode;
    session_.OnProgress(arm_.progress);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kRecovery, id, status}));
    EXPECT_FALSE(session_.has_pending());
  }
}

TEST_F(ArmSessionTest, RecoveryFromNothingIsASuccessAtOnce) {
  ConnectIt();
  EXPECT_EQ(Ask(1, AutomaticErrorRecovery{}), std::nullopt);
  EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kRecovery, 1, 0}));
  EXPECT_FALSE(session_.has_pending());
}

TEST_F(ArmSessionTest, RefusedRecoveriesAreAnsweredAtOnce) {
  ConnectIt();
  std::uint32_t id = 0;
  for (const RecoveryStatus status : {RecoveryStatus::kCommandNotPossibleRejected,
                                      RecoveryStatus::kManualErrorRecoveryRequiredRejected}) {
    arm_.recovery_status = status;
    EXPECT_EQ(Ask(++id, AutomaticErrorRecovery{}), std::nullopt);
    EXPECT_THAT(TakeSeen(), ElementsAre(Seen{kRecovery, id, static_cast<int>(status)}));
  }
}

TEST_F(ArmSessionTest, TheModelLibraryIsSentWhole) {
  ConnectIt();
  EXPECT_EQ(Ask(1, LoadModelLibrary{}), std::nullopt);
  ASSERT_EQ(frames_.size(), 1u);
  EXPECT_EQ(frames_[0].size(), 13u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 1);  // there is none
  frames_.clear();
  for (int i = 0; i < 40000; ++i) arm_.library.push_back(std::byte(i % 251));
  EXPECT_EQ(Ask(2, LoadModelLibrary{}), std::nullopt);
  ASSERT_EQ(frames_.size(), 1u);
  ASSERT_EQ(frames_[0].size(), 13u + arm_.library.size());
  EXPECT_EQ(std::to_integer<int>(frames_[0][12]), 0);
  EXPECT_TRUE(std::ranges::equal(std::span(frames_[0]).subspan(13), arm_.library));
}

TEST_F(ArmSessionTest, ACartesianLimitIsTold) {
  ConnectIt();
  EXPECT_EQ(Ask(1, GetCartesianLimit{1}), std::nullopt);
  ASSERT_EQ(frames_.size(), 1u);
  EXPECT_EQ(frames_[0].size(), 166u);
  EXPECT_EQ(std::to_integer<int>(frames_[0][13 + 7]), 0x3f);  // 1.0, little-endian
}

TEST_F(ArmSessionTest, AClientThatGoesStopsItsMotion) {
  ConnectIt();
  StartMotion(1);
  session_.OnClosed();
  EXPECT_THAT(arm_.asked, ElementsAre("Move", "StopMove"));
  EndMotion(MoveStatus::kPreempted);
  EXPECT_THAT(TakeSeen(), IsEmpty());
  EXPECT_EQ(session_.udp_port(), std::nullopt);
}

TEST_F(ArmSessionTest, AClientThatGoesWithoutAMotionStopsNothing) {
  ConnectIt();
  session_.OnClosed();
  EXPECT_THAT(arm_.asked, IsEmpty());
}

TEST_F(ArmSessionTest, AnEndFromBeforeTheMotionIsNotItsEnd) {
  ConnectIt();
  arm_.progress = {RobotMode::kIdle, false, MoveStatus::kSuccess};  // of another client's
  session_.OnProgress(arm_.progress);
  StartMotion(1);
  session_.OnProgress(arm_.progress);
  EXPECT_THAT(TakeSeen(), IsEmpty());
}

}  // namespace
}  // namespace twin::fci::fci_arm_session_test
