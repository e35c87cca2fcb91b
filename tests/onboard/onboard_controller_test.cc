#include "twin/onboard/onboard_controller.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::onboard::onboard_controller_test {
namespace {

constexpr double kT = 1e-3;
constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};
constexpr MotionModes kVelocity{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointVelocity};

/// INT on a body that does what is desired, driven by hand, one call a cycle.
class OnboardControllerTest : public ::testing::Test {
 protected:
  static OnboardConfig Config() {
    OnboardConfig config;
    config.limits = test::PandaLimits();
    config.cartesian = test::PandaCartesianLimits();
    return config;
  }

  const RobotState& Cycle(const RobotCommand* command = nullptr) {
    const JointDrive& drive = onboard_.Cycle(command, sensors_);
    sensors_.q = drive.q_d;
    sensors_.dq = drive.dq_d;
    sensors_.tau_J = drive.tau;
    onboard_.FillState(sensors_, state_);
    return state_;
  }
  const RobotState& SendPosition(const JointVector& q_c, bool finished = false) {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.q_c = q_c;
    command.motion_generation_finished = finished;
    return Cycle(&command);
  }
  const RobotState& SendVelocity(const JointVector& dq_c, bool finished = false) {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.dq_c = dq_c;
    command.motion_generation_finished = finished;
    return Cycle(&command);
  }
  void StartMotion(const MotionModes& modes) {
    Cycle();
    ASSERT_EQ(onboard_.Move(modes), MoveStatus::kMotionStarted);
    Cycle();
    Cycle();
  }
  /// Speeds joint 1 up to `speed` at `acceleration`, by commanded velocities.
  void SpeedUp(double acceleration, double speed) {
    JointVector dq = state_.dq_d;
    while (dq[0] < speed - 1e-9) {
      dq[0] += acceleration * kT;
      SendVelocity(dq);
    }
  }
  bool Reports(RobotError error) const { return state_.errors[static_cast<std::size_t>(error)]; }

  OnboardController onboard_{Config(), kReady};
  JointSensors sensors_{kReady, {}, {}, kReady, {}};
  RobotState state_;
};

TEST_F(OnboardControllerTest, IdleShowsNoModesAndHoldsItsPosition) {
  for (int i = 0; i < 5; ++i) Cycle();
  EXPECT_EQ(state_.message_id, 5u);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kOther);
  EXPECT_EQ(state_.control_command_success_rate, 0);
  EXPECT_EQ(state_.q_d, kReady);
}

TEST_F(OnboardControllerTest, SwitchesAllModesInOneStateWithTheReferenceAtRest) {
  Cycle();
  ASSERT_EQ(onboard_.Move(kPosition), MoveStatus::kMotionStarted);
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kJointPosition);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kJointImpedance);
  EXPECT_EQ(state_.q_d, kReady);
  EXPECT_EQ(state_.dq_d, JointVector{});
  EXPECT_EQ(state_.O_T_EE_c, state_.O_T_EE_d);
}

TEST_F(OnboardControllerTest, CountsNoLossBeforeTheFirstCommand) {
  StartMotion(kPosition);
  for (int i = 0; i < 100; ++i) Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(onboard_.fate(), record::CommandFate::kNone);
  SendPosition(kReady);
  EXPECT_EQ(onboard_.fate(), record::CommandFate::kServed);
  EXPECT_EQ(state_.control_command_success_rate, 1);
}

TEST_F(OnboardControllerTest, AbortsAMotionWhoseFirstCommandNeverComes) {
  StartMotion(kPosition);
  for (int i = 0; i < 1000 && state_.robot_mode == RobotMode::kMove; ++i) Cycle();
  EXPECT_TRUE(Reports(RobotError::kCommunicationConstraintsViolation));
}

TEST_F(OnboardControllerTest, NineteenLostCommandsAreBridgedWithTheHeldAccelerationAndThenResume) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 0.5);
  const double q = state_.q_d[0];
  const double dq = state_.dq_d[0];
  const double ddq = state_.ddq_d[0];
  ASSERT_NEAR(ddq, 5.0, 1e-9);
  for (int n = 1; n <= 19; ++n) {
    Cycle();
    EXPECT_EQ(onboard_.fate(), record::CommandFate::kHeld);
    EXPECT_NEAR(state_.dq_d[0], dq + n * kT * ddq, 1e-12);
    EXPECT_NEAR(state_.q_d[0], q + n * kT * dq + kT * kT * ddq * n * (n + 1) / 2, 1e-12);
  }
  JointVector next = state_.dq_d;
  next[0] += 5.0 * kT;
  SendVelocity(next);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(onboard_.lost_in_row(), 0u);
}

TEST_F(OnboardControllerTest, TheTwentiethLossAbortsAndTheArmStopsWithinItsLimits) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 1.5);
  for (int n = 0; n < 20; ++n) Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_EQ(state_.control_command_success_rate, 0);
  EXPECT_EQ(state_.errors.count(), 1u);
  EXPECT_TRUE(Reports(RobotError::kCommunicationConstraintsViolation));
  EXPECT_EQ(state_.reflex_reason, state_.errors);
  ASSERT_EQ(onboard_.violations().items().size(), 1u);
  EXPECT_EQ(onboard_.violations().items()[0].value, 20);
  EXPECT_EQ(onboard_.violations().items()[0].message_id, state_.message_id);

  EXPECT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kCommandNotPossibleRejected);
  const JointLimits limits = test::PandaLimits();
  int cycles = 0;
  double last_ddq = state_.ddq_d[0];
  while (!onboard_.reference().AtRest() && ++cycles < 400) {
    Cycle();
    EXPECT_LE(std::abs(state_.ddq_d[0]), limits.ddq_max[0] * (1 + 1e-9));
    EXPECT_LE(std::abs(state_.ddq_d[0] - last_ddq) / kT, limits.dddq_max[0] * (1 + 1e-9));
    last_ddq = state_.ddq_d[0];
  }
  EXPECT_LT(cycles, 150);
  EXPECT_EQ(state_.dq_d, JointVector{});
}

TEST_F(OnboardControllerTest, RecoversAndRunsTheNextMotion) {
  StartMotion(kPosition);
  SendPosition(kReady);
  for (int n = 0; n < 20; ++n) Cycle();
  ASSERT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(onboard_.Move(kPosition), MoveStatus::kCommandNotPossibleRejected);
  ASSERT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kAutomaticErrorRecovery);
  EXPECT_TRUE(state_.errors.none());
  EXPECT_TRUE(state_.reflex_reason.any()) << "it documents the previous motion";
  for (int i = 0; i < 200 && state_.robot_mode != RobotMode::kIdle; ++i) Cycle();
  ASSERT_EQ(state_.robot_mode, RobotMode::kIdle);
  ASSERT_EQ(onboard_.Move(kPosition), MoveStatus::kMotionStarted);
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_TRUE(state_.reflex_reason.none());
}

TEST_F(OnboardControllerTest, AFirstPositionFarFromTheArmIsRefused) {
  StartMotion(kPosition);
  JointVector q_c = kReady;
  q_c[3] += 0.2;
  SendPosition(q_c);
  EXPECT_TRUE(Reports(RobotError::kJointPositionMotionGeneratorStartPoseInvalid));
  EXPECT_EQ(state_.errors.count(), 1u);
  EXPECT_EQ(onboard_.violations().items()[0].axis, 3);
  EXPECT_NEAR(onboard_.violations().items()[0].value, 0.2, 1e-12);
}

TEST_F(OnboardControllerTest, ASmallStepOfThePositionIsAJerkAndALargeOneAnAccelerationToo) {
  StartMotion(kPosition);
  SendPosition(kReady);
  JointVector q_c = kReady;
  q_c[0] += 1e-5;  // 10 rad/s^2 and 10 000 rad/s^3 in one cycle
  SendPosition(q_c);
  EXPECT_EQ(FormatErrors(state_.errors), "[\"joint_motion_generator_acceleration_discontinuity\"]");
  EXPECT_NEAR(onboard_.violations().items()[0].value, 1e4, 1e-3);
  EXPECT_EQ(onboard_.violations().items()[0].limit, 7500);
  EXPECT_EQ(state_.q_d[0], kReady[0]) << "the violating command is not applied";
}

TEST_F(OnboardControllerTest, ALargeStepReportsBothDiscontinuities) {
  StartMotion(kPosition);
  SendPosition(kReady);
  JointVector q_c = kReady;
  q_c[0] += 1e-3;
  SendPosition(q_c);
  EXPECT_EQ(FormatErrors(state_.errors),
            "[\"joint_motion_generator_velocity_discontinuity\", "
            "\"joint_motion_generator_acceleration_discontinuity\"]");
}

TEST_F(OnboardControllerTest, ExceedingTheVelocityGentlyIsAVelocityViolation) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 2.17);
  JointVector dq = state_.dq_d;
  while (state_.robot_mode == RobotMode::kMove) {
    dq[0] += 2.0 * kT;
    SendVelocity(dq);
  }
  EXPECT_EQ(FormatErrors(state_.errors), "[\"joint_motion_generator_velocity_limits_violation\"]");
  EXPECT_GT(onboard_.violations().items()[0].value, 2.175);
}

TEST_F(OnboardControllerTest, RunningIntoAPositionLimitIsAPositionViolation) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 2.0);
  while (state_.robot_mode == RobotMode::kMove) SendVelocity(state_.dq_d);
  EXPECT_EQ(FormatErrors(state_.errors), "[\"joint_motion_generator_position_limits_violation\"]");
  EXPECT_EQ(onboard_.violations().items()[0].limit, 2.8973);
}

TEST_F(OnboardControllerTest, AHeldAccelerationThatLeavesTheEnvelopeAborts) {
  StartMotion(kVelocity);
  SpeedUp(7.0, 2.16);
  for (int n = 0; n < 5 && state_.robot_mode == RobotMode::kMove; ++n) Cycle();
  EXPECT_EQ(FormatErrors(state_.errors), "[\"joint_motion_generator_velocity_limits_violation\"]");
}

TEST_F(OnboardControllerTest, NaNAborts) {
  StartMotion(kPosition);
  SendPosition(kReady);
  JointVector q_c = kReady;
  q_c[5] = std::numeric_limits<double>::quiet_NaN();
  SendPosition(q_c);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(state_.q_d, kReady);
}

TEST_F(OnboardControllerTest, FinishingAtRestEndsWithSuccess) {
  StartMotion(kPosition);
  SendPosition(kReady);
  SendPosition(kReady, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  SendPosition(kReady, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_EQ(onboard_.last_end(), MoveStatus::kSuccess);
}

TEST_F(OnboardControllerTest, FinishingInMotionIsADiscontinuity) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 1.0);
  SendVelocity(state_.dq_d, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_TRUE(Reports(RobotError::kJointMotionGeneratorVelocityDiscontinuity));
  EXPECT_TRUE(Reports(RobotError::kJointMotionGeneratorAccelerationDiscontinuity));
}

TEST_F(OnboardControllerTest, StopMoveDeceleratesStillInMoveAndEndsPreempted) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 1.5);
  onboard_.StopMove();
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_LT(state_.dq_d[0], 1.5);
  for (int i = 0; i < 200 && state_.robot_mode == RobotMode::kMove; ++i) Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(onboard_.last_end(), MoveStatus::kPreempted);
  EXPECT_TRUE(onboard_.reference().AtRest());
  EXPECT_TRUE(state_.errors.none());
}

TEST_F(OnboardControllerTest, StopMoveTooNearTheEndOfARangeAbortsWhereTheRampLeavesIt) {
  StartMotion(kVelocity);
  SpeedUp(5.0, 1.5);
  const double q_max = Config().limits.q_max[0];
  while (state_.q_d[0] < q_max - 0.03) SendVelocity(state_.dq_d);
  onboard_.StopMove();
  RobotState before = state_;
  for (Cycle(); state_.robot_mode == RobotMode::kMove; Cycle()) {
    EXPECT_LE(state_.q_d[0], q_max);
    before = state_;
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(onboard_.last_end(), MoveStatus::kReflexAborted);
  EXPECT_TRUE(Reports(RobotError::kJointMotionGeneratorPositionLimitsViolation));
  EXPECT_GT(state_.q_d[0], q_max);
  EXPECT_NEAR(state_.q_d[0], before.q_d[0] + kT * state_.dq_d[0], 1e-12);
  EXPECT_GE(state_.ddq_d[0], -Config().limits.ddq_max[0]);
  EXPECT_LT(state_.ddq_d[0], 0);
}

TEST_F(OnboardControllerTest, RefusesASecondMotionAndModesItDoesNotOffer) {
  EXPECT_EQ(onboard_.Move({ControllerMode::kOther, MotionGeneratorMode::kJointPosition}),
            MoveStatus::kInvalidArgumentRejected);
  EXPECT_EQ(onboard_.Move({ControllerMode::kJointImpedance, MotionGeneratorMode::kIdle}),
            MoveStatus::kInvalidArgumentRejected);
  StartMotion(kPosition);
  EXPECT_EQ(onboard_.Move(kPosition), MoveStatus::kCommandNotPossibleRejected);
  EXPECT_EQ(onboard_.Configure(setting::JointImpedance{JointVector{}}),
            SetterStatus::kCommandNotPossibleRejected);
}

TEST_F(OnboardControllerTest, TakesStiffnessWithinItsRangeOnly) {
  JointVector K{};
  K.fill(14250);
  EXPECT_EQ(onboard_.Configure(setting::JointImpedance{K}), SetterStatus::kSuccess);
  K[2] = 14251;
  EXPECT_EQ(onboard_.Configure(setting::JointImpedance{K}), SetterStatus::kInvalidArgumentRejected);
  K[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(onboard_.Configure(setting::JointImpedance{K}), SetterStatus::kInvalidArgumentRejected);
}

TEST_F(OnboardControllerTest, RefusesAConfigurationOutOfRangeByName) {
  OnboardConfig config = Config();
  config.joint_impedance.K_theta[3] = -1;
  try {
    const OnboardController refused(config, kReady);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("K_theta[3]"), std::string::npos);
  }
}

TEST_F(OnboardControllerTest, AllocatesAndLocksNothing) {
  StartMotion(kVelocity);
  const test::RealtimeGuard guard;
  JointVector dq{};
  for (int k = 0; k < 10000; ++k) {
    dq[0] = 0.5 * std::sin(2e-3 * k);
    RobotCommand command;
    command.dq_c = dq;
    const JointDrive& drive = onboard_.Cycle(k % 7 == 0 ? nullptr : &command, sensors_);
    sensors_.q = drive.q_d;
    onboard_.FillState(sensors_, state_);
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_EQ(counts.locks, 0);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
}

}  // namespace
}  // namespace twin::onboard::onboard_controller_test
