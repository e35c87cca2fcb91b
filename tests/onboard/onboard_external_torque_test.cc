#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "onboard/control_torque.h"
#include "onboard/rigid_arm.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/onboard/onboard_controller.h"

namespace twin::onboard::onboard_external_torque_test {
namespace {

constexpr double kT = 1e-3;
constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr JointVector kRotor{0.6, 0.6, 0.46, 0.46, 0.2, 0.2, 0.2};
const model::Payload kHand{0.73, {-0.01, 0, 0.03}, {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};
constexpr MotionModes kTorque{ControllerMode::kExternalController,
                              MotionGeneratorMode::kJointVelocity};
constexpr MotionModes kTorqueAndPosition{ControllerMode::kExternalController,
                                         MotionGeneratorMode::kJointPosition};
constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

OnboardConfig PandaOnboard() {
  OnboardConfig config;
  config.limits = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  config.end_effector = kHand;
  config.rotor_inertia = kRotor;
  // Sensors that a test sets look like collisions.
  config.collision_behavior.upper_torque_acc.fill(1e4);
  config.collision_behavior.upper_torque_nominal.fill(1e4);
  config.collision_behavior.upper_force_acc.fill(1e4);
  config.collision_behavior.upper_force_nominal.fill(1e4);
  return config;
}

/// INT on an arm that moves as its model says, or, when held, on sensors set by the test.
class ExternalTorqueTest : public ::testing::Test {
 protected:
  ExternalTorqueTest() { Renew(PandaOnboard()); }

  /// A robot just started.
  void Renew(const OnboardConfig& config) { onboard_.emplace(config, kReady); }
  const RobotState& Cycle(const RobotCommand* command = nullptr) {
    drive_ = onboard_->Cycle(command, sensors_);
    if (!held_) {
      arm_.Step(drive_);
      sensors_ = arm_.sensors();
    }
    onboard_->FillState(sensors_, state_);
    return state_;
  }
  RobotCommand Command(const JointVector& tau_J_d) const {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.q_c = state_.q_d;
    command.tau_J_d = tau_J_d;
    return command;
  }
  const RobotState& SendTorque(const JointVector& tau_J_d, bool finished = false) {
    RobotCommand command = Command(tau_J_d);
    command.motion_generation_finished = finished;
    return Cycle(&command);
  }
  void StartMotion(const MotionModes& modes = kTorque) {
    Cycle();
    ASSERT_EQ(onboard_->Move(modes), MoveStatus::kMotionStarted);
    Cycle();
    Cycle();
  }
  /// Goes to `tau` at 900 Nm/s.
  void RampTo(const JointVector& tau) {
    JointVector next = state_.tau_J_d;
    while (next != tau && state_.robot_mode == RobotMode::kMove) {
      for (std::size_t i = 0; i < kJoints; ++i) {
        next[i] += std::clamp(tau[i] - next[i], -0.9, 0.9);
      }
      SendTorque(next);
    }
  }
  /// Starts a torque motion and pushes joints 1 and 4 until the arm moves fast.
  void GetMoving() {
    StartMotion();
    RampTo({8, 0, 0, 4, 0, 0, 0});
    for (int i = 0; i < 2000 && state_.dq[0] < 1.0; ++i) SendTorque(state_.tau_J_d);
    ASSERT_GE(state_.dq[0], 1.0);
  }
  /// After one cycle in which INT took the arm over at `from`: it follows a reference that starts
  /// there and rests within the limits.
  void ExpectsToComeToRestFrom(const JointSensors& from) {
    const JointLimits limits = test::PandaLimits();
    JointVector dq = from.dq;
    JointVector ddq{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(state_.q_d[i], from.q[i] + kT * state_.dq_d[i], 1e-12);
    }
    int cycles = 0;
    do {
      for (std::size_t i = 0; i < kJoints; ++i) {
        EXPECT_NEAR(state_.dq_d[i], dq[i] + kT * state_.ddq_d[i], 1e-11);
        EXPECT_LE(std::abs(state_.ddq_d[i]), limits.ddq_max[i] * (1 + 1e-9));
        EXPECT_LE(std::abs(state_.ddq_d[i] - ddq[i]) / kT, limits.dddq_max[i] * (1 + 1e-9));
        EXPECT_NEAR(state_.q[i], state_.q_d[i], 5e-3) << "the arm follows, joint " << i + 1;
        EXPECT_LE(std::abs(arm_.ddq()[i]), 1.3 * limits.ddq_max[i]);
      }
      dq = state_.dq_d;
      ddq = state_.ddq_d;
      EXPECT_GE(state_.q_d[0], from.q[0]) << "on along its way, not back";
      Cycle();
    } while (!onboard_->reference().AtRest() && ++cycles < 500);
    EXPECT_TRUE(onboard_->reference().AtRest());
    for (int i = 0; i < 300; ++i) Cycle();
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(state_.dq[i], 0, 1e-3);
      EXPECT_NEAR(state_.q[i], state_.q_d[i], 1e-4);
    }
  }
  bool Reports(RobotError error) const { return state_.errors[static_cast<std::size_t>(error)]; }

  std::optional<OnboardController> onboard_;
  test::RigidArm arm_{kReady, kHand, kRotor};
  bool held_ = false;
  JointSensors sensors_ = arm_.sensors();
  RobotState state_;
  JointDrive drive_;
};

/// The arm does not move, whatever drives it.
class HeldArmTest : public ExternalTorqueTest {
 protected:
  HeldArmTest() { held_ = true; }
};

TEST(IntCombinationsTest, EveryGeneratorGoesWithEveryController) {
  for (const auto controller :
       {ControllerMode::kJointImpedance, ControllerMode::kCartesianImpedance,
        ControllerMode::kExternalController, ControllerMode::kOther}) {
    for (const auto generator :
         {MotionGeneratorMode::kIdle, MotionGeneratorMode::kJointPosition,
          MotionGeneratorMode::kJointVelocity, MotionGeneratorMode::kCartesianPosition,
          MotionGeneratorMode::kCartesianVelocity}) {
      const bool is_none =
          controller == ControllerMode::kOther || generator == MotionGeneratorMode::kIdle;
      OnboardController robot(PandaOnboard(), kReady);
      EXPECT_EQ(robot.Move({controller, generator}),
                is_none ? MoveStatus::kInvalidArgumentRejected : MoveStatus::kMotionStarted)
          << Name(controller) << ", " << Name(generator);
    }
  }
}

TEST_F(HeldArmTest, TheReportedTorqueRunsOnAtTheStart) {
  for (std::size_t i = 0; i < kJoints; ++i) sensors_.q[i] += 1e-4 * static_cast<double>(i + 1);
  Cycle();
  const JointVector tau_J_d = state_.tau_J_d;
  const JointVector tau = drive_.tau;
  const JointImpedance internal(PandaOnboard().joint_impedance.K_theta, 1, kRotor);
  EXPECT_EQ(
      tau_J_d,
      ControlTorque(internal, JointReference::Rest(kReady), sensors_, {.payload = kHand}).tau_J_d);
  ASSERT_EQ(onboard_->Move(kTorque), MoveStatus::kMotionStarted);
  for (int i = 0; i < 10; ++i) {
    Cycle();
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(state_.controller_mode, ControllerMode::kExternalController);
    EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kJointVelocity);
    EXPECT_EQ(state_.tau_J_d, tau_J_d);
    EXPECT_EQ(state_.dq_d, JointVector{});
  }
  SendTorque(tau_J_d);
  EXPECT_EQ(state_.tau_J_d, tau_J_d);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(drive_.tau[i], tau[i], 1e-12);
}

TEST_F(HeldArmTest, TheFirstCommandContinuesFromTheReportedTorque) {
  sensors_.q[0] -= 1e-3;  // the internal controller holds against it with 3 Nm
  StartMotion();
  ASSERT_NEAR(state_.tau_J_d[0], 3, 1e-9);
  SendTorque(JointVector{});
  EXPECT_EQ(FormatErrors(state_.errors), "[\"controller_torque_discontinuity\"]");
  ASSERT_EQ(onboard_->violations().items().size(), 1u);
  EXPECT_NEAR(onboard_->violations().items()[0].value, -3000, 1e-6);
  EXPECT_NEAR(state_.q_d[0], kReady[0], 1e-12) << "the internal controller never gave way";
}

TEST_F(HeldArmTest, AppliesTheCommandAndTheGravityOfArmAndHand) {
  StartMotion();
  const JointVector command{0.5, -0.4, 0.3, -0.2, 0.1, 0, 0.6};
  SendTorque(command);
  EXPECT_EQ(onboard_->fate(), record::CommandFate::kServed);
  EXPECT_EQ(state_.tau_J_d, command);
  const JointVector g = model::ArmModel::Panda().Gravity(sensors_.q, kHand);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(drive_.tau[i] - command[i], g[i], 1e-12);
}

TEST_F(ExternalTorqueTest, ZeroTorqueLeavesTheArmWhereItIs) {
  StartMotion();
  for (int i = 0; i < 1000; ++i) SendTorque(JointVector{});
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(state_.q[i], kReady[i], 1e-9);
}

TEST_F(HeldArmTest, TakesATorqueAboveTheMaximumAndAppliesTheMaximum) {
  StartMotion();
  RampTo({0, 100, 0, 0, 0, 0, -20});
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(state_.tau_J_d, (JointVector{0, 100, 0, 0, 0, 0, -20}));
  EXPECT_EQ(drive_.tau[1], 87);
  EXPECT_EQ(drive_.tau[6], -12);
}

TEST_F(HeldArmTest, HoldsTheLastTorqueBitForBitThroughNineteenLosses) {
  for (const int losses : {1, 19}) {
    Renew(PandaOnboard());
    StartMotion();
    const JointVector command{0.1, 0.2, -0.3, 0.4, -0.5, 0.6, 0.7};
    SendTorque(command);
    const JointVector tau = drive_.tau;
    for (int n = 1; n <= losses; ++n) {
      Cycle();
      EXPECT_EQ(onboard_->fate(), record::CommandFate::kHeld);
      EXPECT_EQ(state_.tau_J_d, command);
      EXPECT_EQ(drive_.tau, tau);
    }
    SendTorque(command);
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(onboard_->lost_in_row(), 0u);
    EXPECT_LT(state_.control_command_success_rate, 1);
  }
}

TEST_F(HeldArmTest, TheTwentiethLossAborts) {
  StartMotion();
  SendTorque(JointVector{});
  for (int n = 1; n <= 20; ++n) {
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove) << "before loss " << n;
    Cycle();
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kOther);
  EXPECT_EQ(FormatErrors(state_.errors), "[\"communication_constraints_violation\"]");
  EXPECT_EQ(state_.reflex_reason, state_.errors);
}

TEST_F(HeldArmTest, MeasuresTheRateFromTheLastAcceptedTorqueHoweverMuchWasLost) {
  StartMotion();
  SendTorque({0.5, 0, 0, 0, 0, 0, 0});
  for (int n = 0; n < 19; ++n) Cycle();
  SendTorque({1.499, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  for (int n = 0; n < 19; ++n) Cycle();
  SendTorque({2.501, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(FormatErrors(state_.errors), "[\"controller_torque_discontinuity\"]");
  EXPECT_NEAR(onboard_->violations().items()[0].value, 1002, 1e-6);
}

TEST_F(HeldArmTest, ATorqueStepBeyondTheRateAbortsAndIsNotApplied) {
  StartMotion();
  SendTorque({0, 0, 1.0, 0, 0, 0, 0});
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  SendTorque({0, 0, -1e-5, 0, 0, 0, 0});
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(FormatErrors(state_.errors), "[\"controller_torque_discontinuity\"]");
  ASSERT_EQ(onboard_->violations().items().size(), 1u);
  const Violation& violation = onboard_->violations().items()[0];
  EXPECT_EQ(violation.axis, 2);
  EXPECT_NEAR(violation.value, -1000.01, 1e-6);
  EXPECT_EQ(violation.limit, -1000);
  EXPECT_EQ(violation.message_id, state_.message_id);
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kReflexAborted);
}

TEST_F(HeldArmTest, ATorqueThatIsNoNumberAbortsAndIsNotApplied) {
  for (const double value : {kNaN, std::numeric_limits<double>::infinity()}) {
    Renew(PandaOnboard());
    StartMotion();
    SendTorque(JointVector{});
    SendTorque({0, 0, 0, 0, 0, 0, value});
    EXPECT_EQ(FormatErrors(state_.errors), "[\"controller_torque_discontinuity\"]");
    for (const double tau : drive_.tau) EXPECT_TRUE(std::isfinite(tau));
    for (const double tau : state_.tau_J_d) EXPECT_TRUE(std::isfinite(tau));
  }
}

TEST_F(HeldArmTest, MeasuredTorqueOutOfRangeEndsEveryRunningMotion) {
  // Default range: 1.2 tau_max, 14.4 Nm for joint 5.
  for (const MotionModes& modes : {kTorque, kTorqueAndPosition, kPosition}) {
    for (const bool has_command : {false, true}) {
      Renew(PandaOnboard());
      sensors_.tau_J[4] = 14.39;
      StartMotion(modes);
      if (has_command) SendTorque(JointVector{});
      Cycle();
      ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
      sensors_.tau_J[4] = -14.41;
      Cycle();  // shows it; the next one judges it
      Cycle();
      EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
      EXPECT_EQ(FormatErrors(state_.errors), "[\"tau_J_range_violation\"]");
      ASSERT_EQ(onboard_->violations().items().size(), 1u);
      EXPECT_EQ(onboard_->violations().items()[0].value, -14.41);
      EXPECT_NEAR(onboard_->violations().items()[0].limit, -14.4, 1e-12);
    }
  }
}

TEST_F(HeldArmTest, MeasuredTorqueDoesNotMatterWhileNoMotionRuns) {
  sensors_.tau_J[4] = -14.41;
  for (int i = 0; i < 5; ++i) Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  ASSERT_EQ(onboard_->Move(kTorque), MoveStatus::kMotionStarted);
  Cycle();
  EXPECT_TRUE(Reports(RobotError::kTauJRangeViolation));
}

TEST_F(HeldArmTest, TheRangeOfTheSensorsCanBeSet) {
  OnboardConfig config = PandaOnboard();
  config.sensing.measured.tau_J_range = JointVector{30, 31, 32, 33, 34, 35, 36};
  Renew(config);
  StartMotion();
  sensors_.tau_J[6] = 35.9;
  Cycle();
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  sensors_.tau_J[6] = 36.1;
  Cycle();
  Cycle();
  EXPECT_TRUE(Reports(RobotError::kTauJRangeViolation));
  EXPECT_EQ(onboard_->violations().items()[0].limit, 36);
}

TEST_F(HeldArmTest, TheGeneratorFeedsTheDesiredMotionAlone) {
  StartMotion();
  RobotCommand command = Command({0.5, 0, 0, 0, 0, 0, 0});
  double q_d = kReady[2];
  for (int k = 1; k <= 100; ++k) {
    command.dq_c[2] = 5e-3 * k;
    q_d += kT * command.dq_c[2];
    Cycle(&command);
  }
  EXPECT_NEAR(state_.q_d[2], q_d, 1e-12);
  EXPECT_NEAR(state_.dq_d[2], 0.5, 1e-12);
  EXPECT_NEAR(state_.ddq_d[2], 5, 1e-9);
  const model::ArmModel& arm = model::ArmModel::Panda();
  EXPECT_EQ(state_.O_T_EE_d, arm.Pose(model::Frame::kEndEffector, state_.q_d));
  const JointVector g = arm.Gravity(sensors_.q, kHand);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(drive_.tau[i], command.tau_J_d[i] + g[i], 1e-12) << "no torque of INT's own";
  }
}

TEST_F(HeldArmTest, TheGeneratorIsCheckedAsEver) {
  StartMotion();
  RobotCommand command = Command(JointVector{});
  command.dq_c[0] = 0.1;
  Cycle(&command);
  EXPECT_EQ(FormatErrors(state_.errors),
            "[\"joint_motion_generator_velocity_discontinuity\", "
            "\"joint_motion_generator_acceleration_discontinuity\"]");
}

TEST_F(HeldArmTest, FinishingWhileTheGeneratorMovesIsADiscontinuity) {
  StartMotion();
  RobotCommand command = Command(JointVector{});
  for (int k = 1; k <= 200; ++k) {
    command.dq_c[0] = 5e-3 * k;
    Cycle(&command);
  }
  command.motion_generation_finished = true;
  Cycle(&command);
  EXPECT_TRUE(Reports(RobotError::kJointMotionGeneratorVelocityDiscontinuity));
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kReflexAborted);
}

TEST_F(HeldArmTest, ReportsGeneratorAndTorqueTogether) {
  StartMotion(kTorqueAndPosition);
  RobotCommand command = Command({0, 2, 0, 0, 0, 0, 0});
  command.q_c[0] += 1e-5;  // jerk alone
  Cycle(&command);
  EXPECT_EQ(FormatErrors(state_.errors),
            "[\"joint_motion_generator_acceleration_discontinuity\", "
            "\"controller_torque_discontinuity\"]");
}

TEST_F(HeldArmTest, TheGeneratorHoldsItsAccelerationOverALossAndTheTorqueStays) {
  StartMotion();
  RobotCommand command = Command({0.5, 0, 0, 0, 0, 0, 0});
  for (int k = 1; k <= 50; ++k) {
    command.dq_c[0] = 4e-3 * k;
    Cycle(&command);
  }
  for (int n = 1; n <= 19; ++n) {
    Cycle();
    EXPECT_NEAR(state_.dq_d[0], 4e-3 * (50 + n), 1e-12);
    EXPECT_EQ(state_.tau_J_d, command.tau_J_d);
  }
}

TEST_F(HeldArmTest, AFirstPositionFarFromTheArmIsRefused) {
  StartMotion(kTorqueAndPosition);
  RobotCommand command = Command(JointVector{});
  command.q_c[3] += 0.2;
  Cycle(&command);
  EXPECT_TRUE(Reports(RobotError::kJointPositionMotionGeneratorStartPoseInvalid));
}

TEST_F(HeldArmTest, AbortsATorqueMotionWhoseFirstCommandNeverComes) {
  StartMotion();
  for (int i = 0; i < 1000 && state_.robot_mode == RobotMode::kMove; ++i) Cycle();
  EXPECT_TRUE(Reports(RobotError::kCommunicationConstraintsViolation));
}

TEST_F(ExternalTorqueTest, FinishedAtRestEndsWithSuccessAtOnce) {
  StartMotion();
  SendTorque(JointVector{});
  SendTorque(JointVector{}, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  int cycles = 0;
  while (state_.robot_mode == RobotMode::kMove && ++cycles < 10) SendTorque(JointVector{}, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_LE(cycles, 3);
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kSuccess);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kOther);
}

TEST_F(ExternalTorqueTest, FinishedInMotionComesToRestFromWhereTheArmIsAndEndsWithSuccess) {
  GetMoving();
  ASSERT_GT(std::abs(state_.q[0] - state_.q_d[0]), 0.05);
  SendTorque(state_.tau_J_d, true);
  EXPECT_EQ(state_.q_d, kReady) << "the finished command's torque acts for its cycle";
  const JointSensors from = sensors_;
  SendTorque(state_.tau_J_d, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  ExpectsToComeToRestFrom(from);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kSuccess);
  EXPECT_TRUE(state_.errors.none());

  ASSERT_EQ(onboard_->Move(kPosition), MoveStatus::kMotionStarted);
  Cycle();
  const JointVector q_d = state_.q_d;
  for (int i = 0; i < 50; ++i) SendTorque(JointVector{});
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(state_.q_d, q_d);
}

TEST_F(ExternalTorqueTest, StopMoveComesToRestStillInMoveAndEndsPreempted) {
  GetMoving();
  const JointSensors from = sensors_;
  onboard_->StopMove();
  SendTorque(state_.tau_J_d);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kExternalController);
  ExpectsToComeToRestFrom(from);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kPreempted);
  EXPECT_TRUE(state_.errors.none());
}

TEST_F(ExternalTorqueTest, StopMoveBeforeTheFirstCommandEndsAtOnce) {
  StartMotion();
  onboard_->StopMove();
  Cycle();
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kPreempted);
  EXPECT_EQ(state_.q_d, kReady);
}

TEST_F(ExternalTorqueTest, AnAbortComesToRestFromWhereTheArmIsAndTheNextMotionRuns) {
  GetMoving();
  const JointSensors from = sensors_;
  SendTorque({kNaN, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_EQ(onboard_->AutomaticErrorRecovery(), RecoveryStatus::kCommandNotPossibleRejected);
  ExpectsToComeToRestFrom(from);
  ASSERT_EQ(onboard_->AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  for (int i = 0; i < 200 && state_.robot_mode != RobotMode::kIdle; ++i) Cycle();
  StartMotion();
  SendTorque(state_.tau_J_d);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(onboard_->fate(), record::CommandFate::kServed);
}

TEST_F(ExternalTorqueTest, TwentyLossesInMotionComeToRestFromWhereTheArmIs) {
  GetMoving();
  for (int n = 0; n < 19; ++n) Cycle();
  ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
  const JointSensors from = sensors_;
  Cycle();
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  ExpectsToComeToRestFrom(from);
}

TEST_F(HeldArmTest, CompensatesFrictionInEveryModeAndReportsTheTorqueWithoutIt) {
  OnboardConfig config = PandaOnboard();
  config.friction_compensation = 0.5;
  Renew(config);
  OnboardController plain(PandaOnboard(), kReady);
  sensors_.dq = {0.01, -0.01, 0.02, -0.02, 0.03, -0.03, 0.01};
  const JointVector tau_f = model::ResidualFriction(sensors_.dq);
  const auto expect_share = [&](const RobotCommand* command) {
    Cycle(command);
    const JointDrive& without = plain.Cycle(command, sensors_);
    RobotState state;
    plain.FillState(sensors_, state);
    EXPECT_EQ(state_.tau_J_d, state.tau_J_d);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(drive_.tau[i], without.tau[i] + 0.5 * tau_f[i], 1e-12);
    }
  };
  expect_share(nullptr);
  ASSERT_EQ(onboard_->Move(kTorque), MoveStatus::kMotionStarted);
  ASSERT_EQ(plain.Move(kTorque), MoveStatus::kMotionStarted);
  expect_share(nullptr);
  expect_share(nullptr);
  const RobotCommand command = Command(state_.tau_J_d);
  expect_share(&command);
  expect_share(nullptr);
}

TEST(ExternalTorqueConfigTest, RefusesWhatIsOutOfRangeByName) {
  const auto refusal = [](const OnboardConfig& config) -> std::string {
    try {
      config.Validate();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(PandaOnboard()), "");
  for (const double share : {-0.1, 1.1, kNaN}) {
    OnboardConfig config = PandaOnboard();
    config.friction_compensation = share;
    EXPECT_NE(refusal(config).find("friction_compensation"), std::string::npos);
  }
  for (const double range : {0.0, -1.0, 1001.0, kNaN}) {
    OnboardConfig config = PandaOnboard();
    config.sensing.measured.tau_J_range = config.limits.tau_max;
    (*config.sensing.measured.tau_J_range)[2] = range;
    EXPECT_NE(refusal(config).find("tau_J_range[2]"), std::string::npos);
  }
}

TEST_F(ExternalTorqueTest, AllocatesAndLocksNothing) {
  StartMotion();
  const test::RealtimeGuard guard;
  JointVector tau = state_.tau_J_d;
  for (int k = 0; k < 2000; ++k) {
    tau[0] = 2 * std::sin(5e-3 * k);
    if (k % 7 == 0) {
      Cycle();
    } else {
      SendTorque(tau, k >= 1500);
    }
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(onboard_->last_end(), MoveStatus::kSuccess);
}

}  // namespace
}  // namespace twin::onboard::onboard_external_torque_test
