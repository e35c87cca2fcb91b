// What people do to the robot, and what its modes let pass.

#include <cmath>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/onboard/onboard_controller.h"

namespace twin::onboard::onboard_modes_test {
namespace {

constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr MotionModes kVelocity{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointVelocity};
constexpr MotionModes kTorque{ControllerMode::kExternalController,
                              MotionGeneratorMode::kJointVelocity};
constexpr MotionModes kPose{ControllerMode::kJointImpedance,
                            MotionGeneratorMode::kCartesianPosition};

/// INT on a body that does what is desired, and that nothing touches.
class OnboardModesTest : public ::testing::Test {
 protected:
  static OnboardConfig Config() {
    OnboardConfig config;
    config.limits = test::PandaLimits();
    config.cartesian = test::PandaCartesianLimits();
    return config;
  }

  void Cycle(const RobotCommand* command = nullptr) {
    drive_ = onboard_.Cycle(command, sensors_);
    if (!drive_.brakes) {
      sensors_.q = drive_.q_d;
      sensors_.dq = drive_.dq_d;
    }
    sensors_.tau_J = model::ArmModel::Panda().InverseDynamics(sensors_.q, sensors_.dq, drive_.ddq_d,
                                                              model::Payload());
    onboard_.FillState(sensors_, state_);
  }
  void Cycles(int count) {
    for (int i = 0; i < count; ++i) Cycle();
  }
  void StartMotion(const MotionModes& modes) {
    Cycle();
    ASSERT_EQ(onboard_.Move(modes), MoveStatus::kMotionStarted);
    Cycles(2);
  }
  /// Joint 1 up to 1 rad/s at 5 rad/s^2.
  void SpeedUp() {
    RobotCommand command;
    for (int k = 1; k <= 200; ++k) {
      command.dq_c[0] = 5e-3 * k;
      Cycle(&command);
    }
    ASSERT_NEAR(state_.dq_d[0], 1, 1e-9);
  }
  /// Cycles until the reference rests. @returns how many.
  int ComeToRest() {
    int cycles = 0;
    while (!onboard_.reference().AtRest() && cycles < 1000) {
      const JointVector before = state_.ddq_d;
      Cycle();
      ++cycles;
      EXPECT_LE(std::abs(state_.ddq_d[0]), 15 * (1 + 1e-9));
      EXPECT_LE(std::abs(state_.ddq_d[0] - before[0]), 7.5 * (1 + 1e-9));
    }
    return cycles;
  }

  OnboardController onboard_{Config(), kReady};
  JointSensors sensors_{kReady, {}, model::ArmModel::Panda().Gravity(kReady, {}), kReady, {}};
  JointDrive drive_;
  RobotState state_;
};

TEST_F(OnboardModesTest, TheUserStopEndsAMotionAndBrakesOnceTheArmRests) {
  StartMotion(kVelocity);
  SpeedUp();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressUserStop));
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kUserStopped);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kOther);
  EXPECT_EQ(onboard_.last_end(), MoveStatus::kEmergencyAborted);
  EXPECT_TRUE(state_.errors.none()) << "it is no error";
  EXPECT_FALSE(drive_.brakes) << "the arm still moves";
  EXPECT_FALSE(onboard_.Operate(PanelAction::kReleaseUserStop));
  EXPECT_GT(ComeToRest(), 60);
  Cycle();
  EXPECT_TRUE(drive_.brakes);
  EXPECT_EQ(onboard_.Move(kVelocity), MoveStatus::kCommandNotPossibleRejected);
  EXPECT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kCommandNotPossibleRejected);
}

TEST_F(OnboardModesTest, AfterTheUserStopTheArmIsHeldWhereItThenIs) {
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressUserStop));
  Cycles(2);
  ASSERT_TRUE(drive_.brakes);
  sensors_.q[3] += 0.02;  // what the brakes let pass
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseUserStop));
  const JointVector q = sensors_.q;
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_FALSE(drive_.brakes);
  EXPECT_EQ(state_.q_d, q);
  EXPECT_EQ(state_.dq_d, JointVector{});
}

TEST_F(OnboardModesTest, TheUserStopEndsATorqueMotionWhereTheArmIs) {
  StartMotion(kTorque);
  RobotCommand command;
  command.tau_J_d = state_.tau_J_d;
  Cycle(&command);
  sensors_.q[0] += 0.1;
  const double q = sensors_.q[0];
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressUserStop));
  Cycle();
  EXPECT_NEAR(state_.q_d[0], q, 1e-3);
}

TEST_F(OnboardModesTest, ClosedBrakesAreModeOther) {
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kCloseBrakes));
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kOther);
  EXPECT_TRUE(drive_.brakes);
  EXPECT_EQ(drive_.tau, JointVector{}) << "motors off";
  EXPECT_EQ(onboard_.Move(kVelocity), MoveStatus::kCommandNotPossibleRejected);
  EXPECT_TRUE(onboard_.Operate(PanelAction::kCloseBrakes)) << "they are";
  ASSERT_TRUE(onboard_.Operate(PanelAction::kOpenBrakes));
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_FALSE(drive_.brakes);
  EXPECT_EQ(onboard_.Move(kVelocity), MoveStatus::kMotionStarted);
}

TEST_F(OnboardModesTest, TheUserStopDoesNotOpenTheBrakes) {
  ASSERT_TRUE(onboard_.Operate(PanelAction::kCloseBrakes));
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressUserStop));
  Cycle();
  EXPECT_TRUE(drive_.brakes);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseUserStop));
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kOther);
  EXPECT_TRUE(drive_.brakes);
}

TEST_F(OnboardModesTest, InGuidingTheReferenceFollowsTheArm) {
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressGuidingButton));
  for (int k = 0; k < 100; ++k) {
    sensors_.q[1] += 2e-4;
    sensors_.dq[1] = 0.2;
    const JointVector q = sensors_.q;
    Cycle();
    EXPECT_EQ(state_.robot_mode, RobotMode::kGuiding);
    EXPECT_EQ(state_.q_d, q);
  }
  EXPECT_EQ(onboard_.Move(kVelocity), MoveStatus::kCommandNotPossibleRejected);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseGuidingButton));
  EXPECT_GT(ComeToRest(), 0) << "the arm was moving";
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(onboard_.Move(kVelocity), MoveStatus::kMotionStarted);
}

TEST_F(OnboardModesTest, AButtonPressedInVainChangesNothing) {
  StartMotion(kVelocity);
  for (const PanelAction action : {PanelAction::kCloseBrakes, PanelAction::kPressGuidingButton}) {
    EXPECT_FALSE(onboard_.Operate(action)) << Name(action);
  }
  for (const PanelAction action :
       {PanelAction::kReleaseUserStop, PanelAction::kReleaseGuidingButton}) {
    EXPECT_TRUE(onboard_.Operate(action)) << Name(action);
  }
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
}

TEST_F(OnboardModesTest, SettersAreRefusedWhileMovingAndInReflex) {
  const Setting setting = setting::Load{.m_load = 1, .F_x_Cload = {}, .I_load = {}};
  StartMotion(kVelocity);
  EXPECT_EQ(onboard_.Configure(setting), SetterStatus::kCommandNotPossibleRejected);
  RobotCommand command;
  command.dq_c[0] = 1;  // far beyond every limit
  Cycle(&command);
  ASSERT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(onboard_.Configure(setting), SetterStatus::kCommandNotPossibleRejected);
  Cycle();
  ASSERT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  Cycles(200);
  EXPECT_EQ(onboard_.Configure(setting), SetterStatus::kSuccess);
  Cycle();
  EXPECT_EQ(state_.m_load, 1);
}

TEST_F(OnboardModesTest, FramesThatAreSetShowInTheState) {
  setting::EndEffectorFrame ee;
  ee.NE_T_EE[14] = 0.1;
  setting::StiffnessFrame K;
  K.EE_T_K[12] = 0.05;
  ASSERT_EQ(onboard_.Configure(ee), SetterStatus::kSuccess);
  ASSERT_EQ(onboard_.Configure(K), SetterStatus::kSuccess);
  Cycle();
  EXPECT_EQ(state_.NE_T_EE, ee.NE_T_EE);
  EXPECT_EQ(state_.EE_T_K, K.EE_T_K);
  EXPECT_NEAR(state_.F_T_EE[14], 0.1, 1e-15);
  EXPECT_EQ(state_.O_T_EE_c, state_.O_T_EE_d);
}

TEST_F(OnboardModesTest, ABadValueIsRefusedAndChangesNothing) {
  EXPECT_EQ(onboard_.Configure(setting::Load{.m_load = -1, .F_x_Cload = {}, .I_load = {}}),
            SetterStatus::kInvalidArgumentRejected);
  EXPECT_EQ(onboard_.Configure(setting::EndEffectorFrame{Transform{}}),
            SetterStatus::kInvalidArgumentRejected);
  Cycle();
  EXPECT_EQ(state_.m_load, 0);
  EXPECT_EQ(state_.NE_T_EE, kIdentityTransform);
}

TEST_F(OnboardModesTest, ACartesianMotionCannotStartStretchedOut) {
  const JointVector stretched{0, 0, 0, -0.467, 0, 1.6, 0.8};  // the flip angle of joint 4
  OnboardController straight(Config(), stretched);
  sensors_.q = stretched;
  straight.FillState(sensors_, state_);
  EXPECT_EQ(straight.Move(kPose), MoveStatus::kStartAtSingularPoseRejected);
  EXPECT_EQ(straight.Move(kVelocity), MoveStatus::kMotionStarted);
}

TEST_F(OnboardModesTest, AMotionCanBeAskedForBeforeTheFirstState) {
  ASSERT_EQ(onboard_.Move(kVelocity), MoveStatus::kMotionStarted);
  Cycles(3);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
}

TEST_F(OnboardModesTest, BeingLedIsNoCollision) {
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressGuidingButton));
  for (int k = 0; k < 100; ++k) {
    onboard_.Cycle(nullptr, sensors_);
    sensors_.tau_J[1] += 1;  // somebody pulls, harder and harder
    onboard_.FillState(sensors_, state_);
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kGuiding);
  EXPECT_EQ(state_.joint_contact[1], 1);
  sensors_.tau_J = model::ArmModel::Panda().Gravity(sensors_.q, {});
  Cycles(200);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseGuidingButton));
  Cycles(2);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(state_.joint_collision, JointVector{});
}

TEST_F(OnboardModesTest, APushWhileIdleIsACollisionThatRecoveryClears) {
  Cycle();
  int k = 0;
  for (; k < 100 && state_.robot_mode == RobotMode::kIdle; ++k) {
    onboard_.Cycle(nullptr, sensors_);
    sensors_.tau_J[1] += 1;
    onboard_.FillState(sensors_, state_);
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_TRUE(state_.errors.any());
  EXPECT_TRUE(state_.reflex_reason.none()) << "no motion was ended";
  Cycles(200);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex) << "latched";
  ASSERT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  Cycles(200);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(state_.joint_collision, JointVector{});
  EXPECT_EQ(state_.cartesian_collision, Vector6{});
}

TEST_F(OnboardModesTest, BeyondAJointsLimitPeopleMustHelp) {
  StartMotion(kVelocity);
  const double inside = sensors_.q[3];
  sensors_.q[3] = -0.05;  // the limit is -0.0698, and a margin
  onboard_.FillState(sensors_, state_);
  onboard_.Cycle(nullptr, sensors_);
  onboard_.FillState(sensors_, state_);
  ASSERT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_TRUE(state_.errors[static_cast<std::size_t>(RobotError::kJointPositionLimitsViolation)]);
  EXPECT_EQ(onboard_.AutomaticErrorRecovery(),
            RecoveryStatus::kManualErrorRecoveryRequiredRejected);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressGuidingButton));
  sensors_.q[3] = inside;
  onboard_.Cycle(nullptr, sensors_);
  onboard_.FillState(sensors_, state_);
  EXPECT_EQ(state_.robot_mode, RobotMode::kGuiding);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseGuidingButton));
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex) << "the error stands until recovery";
  EXPECT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
}

TEST_F(OnboardModesTest, AMotionStartsAtRestAsItsClientReadsIt) {
  for (const MotionGeneratorMode generator :
       {MotionGeneratorMode::kJointPosition, MotionGeneratorMode::kJointVelocity,
        MotionGeneratorMode::kCartesianPosition, MotionGeneratorMode::kCartesianVelocity}) {
    Cycle();
    ASSERT_EQ(onboard_.Move({ControllerMode::kJointImpedance, generator}),
              MoveStatus::kMotionStarted);
    for (int k = 0; k < 3; ++k) {
      Cycle();
      EXPECT_EQ(state_.motion_generator_mode, generator);
      EXPECT_EQ(state_.q_d, kReady);
      EXPECT_EQ(state_.O_T_EE_c, state_.O_T_EE_d);
      EXPECT_EQ(state_.O_dP_EE_c, Vector6{});
      EXPECT_EQ(state_.O_ddP_EE_c, Vector6{});
      EXPECT_EQ(state_.elbow_c, state_.elbow_d);
      EXPECT_EQ(state_.delbow_c, Elbow{});
    }
    onboard_.StopMove();
    Cycle();
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_modes_test
