#include "twin/loop/control_tick.h"

#include <cmath>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::loop::loop_control_tick_test {
namespace {

constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};

class ControlTickTest : public ::testing::Test {
 protected:
  RobotState State(bool moving) {
    RobotState state;
    state.message_id = ++id_;
    state.q_d = q_d_;
    if (moving) {
      state.robot_mode = RobotMode::kMove;
      state.controller_mode = kPosition.controller;
      state.motion_generator_mode = kPosition.generator;
    } else {
      state.robot_mode = RobotMode::kIdle;
    }
    return state;
  }
  void Put(const JointVector& q, std::uint64_t based_on, bool finished = false) {
    Deposit deposit;
    deposit.target.joint.q = q;
    deposit.based_on = based_on;
    deposit.finished = finished;
    exchange_.deposits.Publish(deposit);
  }

  /// A tick with the next state, `off` its instant on the grid.
  const RobotCommand* Step(ControlTick& tick, bool moving, Duration off = {}) {
    state_ = State(moving);
    return tick.Tick(state_, Time(kCycle * static_cast<std::int64_t>(id_) + off));
  }

  Exchange exchange_;
  TickConfig config_;
  RobotState state_;
  JointVector q_d_{};
  std::uint64_t id_ = 0;
};

TEST_F(ControlTickTest, PublishesEveryState) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  EXPECT_EQ(tick.Tick(State(false), Time(kCycle)), nullptr);
  ASSERT_TRUE(exchange_.states.Refresh());
  EXPECT_EQ(exchange_.states.value().state.message_id, 1u);
  EXPECT_EQ(exchange_.states.value().read, Time(kCycle));
  EXPECT_EQ(tick.record().action, record::TickAction::kPublished);
}

TEST_F(ControlTickTest, AStaleDepositNeverPassesTheGate) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  EXPECT_EQ(Step(tick, false), nullptr);
  JointVector far{};
  far[0] = 0.1;
  Put(far, id_);
  tick.Activate(kPosition);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(Step(tick, true), nullptr);
}

TEST_F(ControlTickTest, OpensOnceTheControllerHasSeenAStateOfTheMotion) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  EXPECT_EQ(Step(tick, true), nullptr);
  Put(q_d_, id_);
  const RobotCommand* command = Step(tick, true);
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->message_id, id_);
  EXPECT_EQ(command->q_c, q_d_);
  EXPECT_EQ(tick.record().action, record::TickAction::kWritten);
}

TEST_F(ControlTickTest, NeverAnswersTheFirstStateOfAMotion) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  Put(q_d_, 1000);
  EXPECT_EQ(Step(tick, true), nullptr);
  EXPECT_NE(Step(tick, true), nullptr);
}

TEST_F(ControlTickTest, ClosesAgainWhenTheMotionIsOver) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  ASSERT_NE(Step(tick, true), nullptr);
  EXPECT_EQ(Step(tick, false), nullptr);
}

TEST_F(ControlTickTest, CorrectsTheReferenceByLambda) {
  config_.lambda = 0.25;
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  JointVector target{};
  target[2] = 4e-3;
  Put(target, id_);
  const RobotCommand* command = Step(tick, true);
  ASSERT_NE(command, nullptr);
  EXPECT_DOUBLE_EQ(command->q_c[2], 1e-3);
}

TEST_F(ControlTickTest, ARawStreamGoesOutAsItIs) {
  config_.generator = Generator::kNone;
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  const JointVector target{1, 2, 3, 4, 5, 6, 7};
  Put(target, id_);
  const RobotCommand* command = Step(tick, true);
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->q_c, target);
}

TEST_F(ControlTickTest, FinishesOnlyWhenTheReferenceHasArrived) {
  config_.lambda = 0.5;
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  JointVector goal{};
  goal[0] = 1e-3;
  Put(goal, id_, true);
  int commands = 0;
  const RobotCommand* command = nullptr;
  do {
    command = Step(tick, true);
    ASSERT_NE(command, nullptr);
    q_d_ = command->q_c;
    ASSERT_LT(++commands, 20);
  } while (!command->motion_generation_finished);
  // The error halves each cycle: 1e-3 / 2^4 is the first below the tolerance of 1e-4, seen one
  // later.
  EXPECT_EQ(commands, 5);
  EXPECT_EQ(tick.record().action, record::TickAction::kFinished);
}

TEST_F(ControlTickTest, ALostFinishDoesNotBindTheNextCommand) {
  config_.limits = test::PandaLimits();
  config_.viability = 20;
  q_d_ = {0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_, true);
  const RobotCommand* command = Step(tick, true);
  ASSERT_NE(command, nullptr);
  EXPECT_TRUE(command->motion_generation_finished);
  // Its loss leaves the robot with the acceleration that it had (world 97131 of the campaign).
  RobotState drifting = State(true);
  drifting.q_d[1] += 5e-5;
  drifting.dq_d[1] = 4e-3;
  drifting.ddq_d[1] = 0.3;
  command = tick.Tick(drifting, Time(kCycle * static_cast<std::int64_t>(id_)));
  ASSERT_NE(command, nullptr);
  EXPECT_FALSE(command->motion_generation_finished);
  EXPECT_EQ(tick.record().action, record::TickAction::kWritten);
}

TEST_F(ControlTickTest, RateMatchingKeepsItsPaceOverLostStates) {
  // A source at 250 Hz steps by 4; behind the matcher the target rises by 1 a cycle, whether or not
  // every state arrives.
  config_.generator = Generator::kNone;
  config_.source_rate_hz = 250;
  config_.period_tolerance = std::chrono::microseconds(250);
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(JointVector{}, id_);
  static_cast<void>(Step(tick, true));
  JointVector target{};
  target.fill(4);
  Put(target, id_);
  id_ += 2;  // two states are lost; the third comes out of time and is not answered
  EXPECT_EQ(Step(tick, true), nullptr);
  Put(target, id_);
  const RobotCommand* command = Step(tick, true);
  ASSERT_NE(command, nullptr);
  EXPECT_DOUBLE_EQ(command->q_c[0], 4) << "where the ramp would be without the loss";
}

TEST_F(ControlTickTest, AStateOutOfTimeSkipsExactlyTwoWrites) {
  config_.period_tolerance = std::chrono::microseconds(250);
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  ASSERT_NE(Step(tick, true), nullptr);
  // 1.3 ms after the last; the next is back on the grid, 0.7 ms after it.
  EXPECT_EQ(Step(tick, true, std::chrono::microseconds(300)), nullptr);
  EXPECT_EQ(tick.record().action, record::TickAction::kSkipped);
  EXPECT_EQ(Step(tick, true), nullptr);
  EXPECT_EQ(tick.record().action, record::TickAction::kSkipped);
  for (int i = 0; i < 10; ++i) EXPECT_NE(Step(tick, true), nullptr);
}

TEST_F(ControlTickTest, AStateWithinTheToleranceIsAnswered) {
  config_.period_tolerance = std::chrono::microseconds(250);
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  ASSERT_NE(Step(tick, true), nullptr);
  EXPECT_NE(Step(tick, true, std::chrono::microseconds(250)), nullptr);
  EXPECT_NE(Step(tick, true), nullptr);
}

TEST_F(ControlTickTest, WithoutAToleranceEveryStateIsAnswered) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  EXPECT_NE(Step(tick, true, std::chrono::microseconds(900)), nullptr);
}

TEST_F(ControlTickTest, AStaleDepositATenthOfARadianOffTransmitsNothing) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  static_cast<void>(Step(tick, false));
  JointVector off = q_d_;
  off.fill(0.1);
  Put(off, id_);
  tick.Activate(kPosition);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(Step(tick, true), nullptr);
    ASSERT_EQ(tick.record().action, record::TickAction::kPublished);
  }
}

TEST_F(ControlTickTest, ATargetThatIsNoNumberIsNeverSent) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  JointVector target{};
  target[3] = std::nan("");
  Put(target, id_);
  EXPECT_EQ(Step(tick, true), nullptr);
  EXPECT_EQ(tick.record().action, record::TickAction::kInvalid);
}

TEST_F(ControlTickTest, WhatAControllerGivesAsItGivesUpIsNeverSent) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  ASSERT_NE(Step(tick, true), nullptr);
  Deposit deposit;
  deposit.target.joint.q = q_d_;
  deposit.based_on = id_;
  deposit.failed = true;
  exchange_.deposits.Publish(deposit);
  EXPECT_EQ(Step(tick, true), nullptr);
  EXPECT_EQ(tick.record().action, record::TickAction::kInvalid);
}

TEST_F(ControlTickTest, RecordsNoCommandWhereTheRobotItselfMustStop) {
  config_.generator = Generator::kNone;
  config_.limits = test::PandaLimits();
  config_.cartesian = test::PandaCartesianLimits();
  config_.lab.emplace().force_max = 20;
  q_d_ = {0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
  ControlTick tick(config_, control::CommandInterface::kTorque, exchange_);
  const MotionModes modes{ControllerMode::kExternalController, kPosition.generator};
  tick.Activate(modes);
  const auto step = [&](double force) {
    state_ = State(true);
    state_.controller_mode = modes.controller;
    state_.q = q_d_;
    state_.O_F_ext_hat_K[0] = force;
    return tick.Tick(state_, Time(kCycle * static_cast<std::int64_t>(id_)));
  };
  static_cast<void>(step(0));
  Put(q_d_, id_);
  ASSERT_NE(step(0), nullptr);
  EXPECT_EQ(tick.record().command.message_id, id_);
  EXPECT_EQ(step(30), nullptr);
  EXPECT_EQ(tick.record().action, record::TickAction::kLimited);
  EXPECT_EQ(tick.record().command.message_id, 0u);
}

TEST_F(ControlTickTest, CountsStatesThatNeverCame) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  static_cast<void>(Step(tick, false));
  id_ += 3;
  static_cast<void>(Step(tick, false));
  EXPECT_EQ(tick.record().skipped_states, 3u);
}

TEST_F(ControlTickTest, RefusesAGeneratorThatDoesNotFitTheInterface) {
  EXPECT_THROW(ControlTick(config_, control::CommandInterface::kJointVelocity, exchange_),
               InputError);
}

TEST_F(ControlTickTest, RecordsWhatTheViabilityFilterDidToEachAnswer) {
  config_.generator = Generator::kNone;
  config_.viability = 19;
  config_.limits = test::PandaLimits();
  q_d_ = {0, 0, 0, -1.5, 0, 1.5, 0};
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  EXPECT_EQ(Step(tick, true), nullptr);
  EXPECT_FALSE(tick.record().margin.has_value()) << "nothing was answered";
  JointVector target = q_d_;
  target[2] += 0.1;
  Put(target, id_);
  ASSERT_NE(Step(tick, true), nullptr);
  EXPECT_EQ(tick.record().kept_back, 0b100);
  EXPECT_GT(tick.record().margin.value_or(0), 0);
  EXPECT_EQ(Step(tick, false), nullptr);
  EXPECT_EQ(tick.record().kept_back, 0);
  EXPECT_FALSE(tick.record().margin.has_value()) << "of this tick, not of the last";
}

TEST_F(ControlTickTest, AllocatesAndLocksNothingInTenThousandTicks) {
  ControlTick tick(config_, control::CommandInterface::kJointPosition, exchange_);
  tick.Activate(kPosition);
  static_cast<void>(Step(tick, true));
  Put(q_d_, id_);
  const test::RealtimeGuard guard;
  std::uint64_t written = 0;
  for (int i = 0; i < 10000; ++i) {
    Put(q_d_, id_);
    written += Step(tick, true) != nullptr ? 1u : 0u;
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_EQ(counts.locks, 0);
  EXPECT_EQ(written, 10000u);
}

}  // namespace
}  // namespace twin::loop::loop_control_tick_test
