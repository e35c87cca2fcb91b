#include "twin/backend/refusal.h"

#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::backend::backend_refusal_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr MotionModes kModes{ControllerMode::kCartesianImpedance,
                             MotionGeneratorMode::kCartesianVelocity};

template <typename Kind>
std::string TextOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Kind& error) {
    return error.what();
  }
  return "granted";
}

TEST(RefusalTest, GrantsWhatWasGranted) {
  EXPECT_NO_THROW(RequireStarted(MoveStatus::kMotionStarted, kModes, RobotMode::kIdle));
  EXPECT_NO_THROW(RequireSet(SetterStatus::kSuccess, setting::Load{}, RobotMode::kIdle));
  EXPECT_NO_THROW(RequireRecovered(RecoveryStatus::kSuccess, RobotMode::kIdle));
  EXPECT_NO_THROW(RequireOperated(true, PanelAction::kOpenBrakes, RobotMode::kOther));
  EXPECT_NO_THROW(RequireStarted(HandStart{1, {}}, hand::Homing{}));
}

TEST(RefusalTest, NamesModeAndWayOut) {
  const auto in_mode = [](RobotMode mode) {
    return TextOf<RobotFault>(
        [mode] { RequireStarted(MoveStatus::kCommandNotPossibleRejected, kModes, mode); });
  };
  EXPECT_THAT(in_mode(RobotMode::kOther), AllOf(HasSubstr("(\"Other\")"), HasSubstr("brakes")));
  EXPECT_THAT(in_mode(RobotMode::kReflex), AllOf(HasSubstr("(\"Reflex\")"), HasSubstr("recover")));
  EXPECT_THAT(in_mode(RobotMode::kUserStopped), HasSubstr("release the user stop"));
  EXPECT_THAT(in_mode(RobotMode::kMove), HasSubstr("end the motion first"));
  EXPECT_THAT(in_mode(RobotMode::kGuiding), HasSubstr("guiding button"));
}

TEST(RefusalTest, NamesWhatIsNotOffered) {
  EXPECT_THAT(TextOf<RobotFault>([] {
                RequireStarted(MoveStatus::kInvalidArgumentRejected, kModes, RobotMode::kIdle);
              }),
              AllOf(HasSubstr("cartesian_velocity"), HasSubstr("cartesian_impedance")));
}

TEST(RefusalTest, NamesTheBadValueOfASetting) {
  setting::JointImpedance impedance;
  impedance.K_theta[3] = -1;
  EXPECT_THAT(TextOf<InputError>([&] {
                RequireSet(SetterStatus::kInvalidArgumentRejected, impedance, RobotMode::kIdle);
              }),
              AllOf(HasSubstr("Set Joint Impedance"), HasSubstr("K_theta[3] is -1")));
}

TEST(RefusalTest, TellsWhyARecoveryEnded) {
  const auto told = [](RecoveryStatus status) {
    return TextOf<RobotFault>([status] { RequireRecovered(status, RobotMode::kReflex); });
  };
  EXPECT_THAT(told(RecoveryStatus::kManualErrorRecoveryRequiredRejected),
              HasSubstr("guide the arm"));
  EXPECT_THAT(told(RecoveryStatus::kEmergencyAborted), HasSubstr("user stop"));
  EXPECT_THAT(told(RecoveryStatus::kReflexAborted), HasSubstr("another error"));
  EXPECT_THAT(told(RecoveryStatus::kCommandNotPossibleRejected), HasSubstr("(\"Reflex\")"));
}

TEST(RefusalTest, KnowsHowEveryMotionEnded) {
  EXPECT_EQ(EndOf(MoveStatus::kMotionStarted), MotionEnd::kNone);
  EXPECT_EQ(EndOf(MoveStatus::kSuccess), MotionEnd::kSuccess);
  EXPECT_EQ(EndOf(MoveStatus::kPreempted), MotionEnd::kPreempted);
  EXPECT_EQ(EndOf(MoveStatus::kEmergencyAborted), MotionEnd::kUserStopped);
  for (const MoveStatus status :
       {MoveStatus::kReflexAborted, MoveStatus::kInputErrorAborted, MoveStatus::kAborted}) {
    EXPECT_EQ(EndOf(status), MotionEnd::kAborted);
  }
}

}  // namespace
}  // namespace twin::backend::backend_refusal_test
