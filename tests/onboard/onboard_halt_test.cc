// What INT does when it cannot go on at all: what is measured or computed is no number, or the arm
// does not come to rest.

#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/onboard/onboard_controller.h"

namespace twin::onboard::onboard_halt_test {
namespace {

constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr MotionModes kVelocity{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointVelocity};
constexpr MotionModes kTorque{ControllerMode::kExternalController,
                              MotionGeneratorMode::kJointVelocity};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr auto kInstability = static_cast<std::size_t>(RobotError::kInstabilityDetected);

/// Every double of the state: they lie one after the other, but for the last.
bool IsFiniteState(const RobotState& state) {
  constexpr std::size_t kBegin = offsetof(RobotState, O_T_EE);
  constexpr std::size_t kEnd = offsetof(RobotState, motion_generator_mode);
  for (std::size_t at = kBegin; at + sizeof(double) <= kEnd; at += sizeof(double)) {
    double value = 0;
    std::memcpy(&value, reinterpret_cast<const char*>(&state) + at, sizeof(value));
    if (!std::isfinite(value)) return false;
  }
  return std::isfinite(state.control_command_success_rate);
}

/// INT on a body that does what is desired, unless a test says what it does.
class OnboardHaltTest : public ::testing::Test {
 protected:
  static OnboardConfig Config() {
    OnboardConfig config;
    config.limits = test::PandaLimits();
    config.cartesian = test::PandaCartesianLimits();
    // The arm that moves as a test says looks pushed: that is not what is looked at.
    setting::CollisionBehavior& behavior = config.collision_behavior;
    behavior.upper_torque_acc.fill(1e6);
    behavior.upper_torque_nominal.fill(1e6);
    behavior.upper_force_acc.fill(1e6);
    behavior.upper_force_nominal.fill(1e6);
    config.end_effector = {
        .m = 0.73, .F_x_C = {-0.01, 0, 0.03}, .I = {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};
    return config;
  }

  void Cycle(const RobotCommand* command = nullptr) {
    drive_ = onboard_.Cycle(command, sensors_);
    if (!drive_.brakes) {
      sensors_.q = drive_.q_d;
      sensors_.dq = drive_.dq_d;
    }
    sensors_.tau_J = model::ArmModel::Panda().Gravity(sensors_.q, Config().end_effector);
    onboard_.FillState(sensors_, state_);
  }
  void Cycles(int count) {
    for (int i = 0; i < count; ++i) Cycle();
  }
  /// A cycle in which joint 4 is measured to move like that, wherever it goes.
  void CycleMoving(double dq) {
    drive_ = onboard_.Cycle(nullptr, sensors_);
    sensors_.dq = {};
    sensors_.dq[3] = drive_.brakes ? 0 : dq;
    onboard_.FillState(sensors_, state_);
  }
  void StartMotion(const MotionModes& modes) {
    Cycle();
    ASSERT_EQ(onboard_.Move(modes), MoveStatus::kMotionStarted);
    Cycles(2);
  }
  /// A motion that ends with Success where the arm stands.
  void MoveNowhere() {
    StartMotion(kVelocity);
    RobotCommand command;
    Cycle(&command);
    command.motion_generation_finished = true;
    for (int k = 0; k < 5 && state_.robot_mode == RobotMode::kMove; ++k) Cycle(&command);
    ASSERT_EQ(onboard_.last_end(), MoveStatus::kSuccess);
    ASSERT_EQ(state_.robot_mode, RobotMode::kIdle);
  }
  [[nodiscard]] bool IsHalted() const {
    return drive_.brakes && drive_.tau == JointVector{} && state_.errors.test(kInstability) &&
           state_.robot_mode == RobotMode::kReflex;
  }

  OnboardController onboard_{Config(), kReady};
  JointSensors sensors_{kReady, {}, model::ArmModel::Panda().Gravity(kReady, {}), kReady, {}};
  JointDrive drive_;
  RobotState state_;
};

TEST_F(OnboardHaltTest, AMeasurementThatIsNoNumberEndsTheMotionInItsOwnState) {
  for (JointVector* values :
       {&sensors_.q, &sensors_.dq, &sensors_.tau_J, &sensors_.theta, &sensors_.dtheta}) {
    SCOPED_TRACE((values - &sensors_.q));
    StartMotion(kVelocity);
    RobotCommand command;
    Cycle(&command);
    const JointSensors good = sensors_;
    (*values)[2] = kNaN;
    onboard_.FillState(sensors_, state_);
    EXPECT_TRUE(IsFiniteState(state_));
    EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
    EXPECT_EQ(state_.reflex_reason.to_ullong(), 1ULL << kInstability);
    EXPECT_EQ(state_.q, good.q) << "the last that was measured";
    EXPECT_EQ(onboard_.last_end(), MoveStatus::kReflexAborted);
    ASSERT_FALSE(onboard_.violations().empty());
    EXPECT_TRUE(std::isnan(onboard_.violations().items().front().value));
    drive_ = onboard_.Cycle(&command, sensors_);
    EXPECT_TRUE(IsHalted());
    // It measures again, and people may go on.
    sensors_ = good;
    Cycles(2);
    EXPECT_TRUE(IsHalted());
    ASSERT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
    Cycles(200);
    EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
    EXPECT_FALSE(drive_.brakes);
  }
}

TEST_F(OnboardHaltTest, ATorqueThatIsNoNumberReachesNoJoint) {
  StartMotion(kVelocity);
  sensors_.dq.fill(1e200);  // whose Coriolis torque is infinite
  drive_ = onboard_.Cycle(nullptr, sensors_);
  for (const double tau : drive_.tau) EXPECT_EQ(tau, 0);
  EXPECT_TRUE(drive_.brakes);
  onboard_.FillState(sensors_, state_);
  EXPECT_TRUE(IsHalted());
  EXPECT_TRUE(IsFiniteState(state_));
}

TEST_F(OnboardHaltTest, WhateverIsMeasuredEveryStateIsFinite) {
  const Random random(4, RandomStream::kTest);
  std::uint32_t draw = 0;
  const auto any = [&random, &draw] {
    const double sign = random.Uniform(1, ++draw) < 0.5 ? -1 : 1;
    const double kind = random.Uniform(2, draw);
    if (kind < 0.02) return kNaN;
    if (kind < 0.04) return sign * std::numeric_limits<double>::infinity();
    return sign * std::pow(10, 616 * random.Uniform(3, draw) - 308);
  };
  for (int k = 0; k < 3000; ++k) {
    JointSensors measured = sensors_;
    for (JointVector* values :
         {&measured.q, &measured.dq, &measured.tau_J, &measured.theta, &measured.dtheta}) {
      if (random.Uniform(4, static_cast<std::uint32_t>(k)) < 0.3) continue;
      for (double& value : *values) value = any();
    }
    drive_ = onboard_.Cycle(nullptr, measured);
    onboard_.FillState(measured, state_);
    ASSERT_TRUE(IsFiniteState(state_)) << k;
    for (const double tau : drive_.tau) ASSERT_TRUE(std::isfinite(tau)) << k;
    static_cast<void>(onboard_.AutomaticErrorRecovery());
    static_cast<void>(onboard_.Move(k % 2 == 0 ? kVelocity : kTorque));
  }
}

TEST_F(OnboardHaltTest, AnArmThatDoesNotComeToRestIsBrakedASecondAfterItsMotion) {
  MoveNowhere();
  for (int k = 1; k < 1000; ++k) {
    CycleMoving(0.3 * std::sin(0.06 * k));  // 10 Hz: slow at times, never for long
    ASSERT_TRUE(state_.errors.none()) << k;
  }
  int more = 0;
  while (!drive_.brakes && ++more < 10) CycleMoving(0.3);
  EXPECT_LE(more, 2);
  EXPECT_TRUE(IsHalted());
  const Violation& violation = onboard_.violations().items().front();
  EXPECT_EQ(violation.axis, 3);
  EXPECT_EQ(violation.limit, 0.05);
  EXPECT_EQ(state_.reflex_reason.to_ullong(), 0) << "it documents the motion, which succeeded";
  ASSERT_EQ(onboard_.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
  Cycles(200);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_FALSE(drive_.brakes);
}

TEST_F(OnboardHaltTest, AnArmThatMovesOnAfterAReflexIsBraked) {
  StartMotion(kVelocity);
  RobotCommand command;
  command.dq_c[0] = 1;  // far beyond every limit
  Cycle(&command);
  ASSERT_EQ(state_.robot_mode, RobotMode::kReflex);
  const RobotErrors why = state_.reflex_reason;
  for (int k = 0; k < 1002; ++k) CycleMoving(2.8);
  EXPECT_TRUE(IsHalted());
  EXPECT_EQ(state_.reflex_reason, why);
  EXPECT_EQ((state_.errors & ~why).to_ullong(), 1ULL << kInstability);
}

TEST_F(OnboardHaltTest, SlowerThanTheBoundIsRest) {
  MoveNowhere();
  for (int k = 0; k < 5000; ++k) CycleMoving(0.0499);
  EXPECT_TRUE(state_.errors.none());
}

TEST_F(OnboardHaltTest, WhoIsPushedAndComesToRestMayBePushedAgain) {
  MoveNowhere();
  for (int k = 0; k < 5000; ++k) CycleMoving(k % 1000 < 890 ? 0.3 : 0);
  EXPECT_TRUE(state_.errors.none());
}

TEST_F(OnboardHaltTest, WhoIsLedMayMove) {
  Cycle();
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressGuidingButton));
  for (int k = 0; k < 3000; ++k) CycleMoving(0.5);
  EXPECT_EQ(state_.robot_mode, RobotMode::kGuiding);
  EXPECT_TRUE(state_.errors.none());
}

TEST_F(OnboardHaltTest, PeopleCanLeadAnArmThatWasHalted) {
  MoveNowhere();
  for (int k = 0; k < 1002; ++k) CycleMoving(0.3);
  ASSERT_TRUE(IsHalted());
  ASSERT_TRUE(onboard_.Operate(PanelAction::kPressGuidingButton));
  Cycles(2);
  EXPECT_FALSE(drive_.brakes);
  ASSERT_TRUE(onboard_.Operate(PanelAction::kReleaseGuidingButton));
  Cycles(2);
  EXPECT_TRUE(IsHalted());
}

}  // namespace
}  // namespace twin::onboard::onboard_halt_test
