#include "twin/loop/command_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::loop::loop_command_chain_test {
namespace {

using control::CommandInterface;
using reference::Target;

TickConfig Raw() {
  TickConfig config;
  config.generator = Generator::kNone;
  return config;
}

RobotCommand After(const TickConfig& config, CommandInterface interface, const RobotState& state,
                   const Target& target) {
  CommandChain chain(config, interface);
  chain.Reset(state);
  RobotCommand command;
  chain.Next(state, target, true, 1, {}, command);
  return command;
}

TEST(CommandChainTest, FillsTheFieldOfItsInterface) {
  Target target;
  target.joint.q.fill(0.1);
  target.joint.dq.fill(0.2);
  target.tau_J_d.fill(0.3);
  target.pose.O_T_EE[12] = 0.4;
  const RobotState state;
  EXPECT_EQ(After(Raw(), CommandInterface::kJointPosition, state, target).q_c, target.joint.q);
  EXPECT_EQ(After(Raw(), CommandInterface::kJointVelocity, state, target).dq_c, target.joint.dq);
  EXPECT_EQ(After(Raw(), CommandInterface::kTorque, state, target).tau_J_d, target.tau_J_d);
  EXPECT_EQ(After(Raw(), CommandInterface::kCartesianPose, state, target).O_T_EE_c,
            target.pose.O_T_EE);
}

TEST(CommandChainTest, ATorqueCommandGoesWithTheZeroVelocityGenerator) {
  Target target;
  target.joint.dq.fill(1);
  target.tau_J_d.fill(1);
  EXPECT_EQ(After(Raw(), CommandInterface::kTorque, {}, target).dq_c, JointVector{});
}

TEST(CommandChainTest, ThePoseGeneratorMovesByTheTwistAndCorrectsByLambda) {
  TickConfig config;
  config.generator = Generator::kCartesian;
  config.lambda = 0.01;
  Target target;
  target.pose.O_T_EE[13] = 0.1;
  target.pose.O_dP_EE[0] = 0.2;
  const Transform command = After(config, CommandInterface::kCartesianPose, {}, target).O_T_EE_c;
  EXPECT_NEAR(command[12], 0.2e-3, 1e-15);
  EXPECT_NEAR(command[13], 0.1 * 0.01, 1e-15);
}

TEST(CommandChainTest, TheLowPassScalesAnIncrementalCommand) {
  // Behind the generator every command is q_d and an increment; libfranka's filter takes 0.386 of
  // it.
  TickConfig config;
  config.low_pass_hz = 100;
  Target target;
  target.joint.dq.fill(1);
  const JointVector q_c = After(config, CommandInterface::kJointPosition, {}, target).q_c;
  EXPECT_NEAR(q_c[0], 0.385870e-3, 1e-9);
}

TEST(CommandChainTest, TheViabilityFilterStandsBehindTheLimiter) {
  TickConfig config = Raw();
  config.limiter = reference::ClientLimits::Of(test::PandaLimits(), test::PandaCartesianLimits());
  Target target;
  target.joint.q = {1, 1, 1, -1, 1, 1, 1};
  RobotState state;
  state.q_d = {0, 0, 0, -1.5, 0, 1.5, 0};
  // Half of libfranka's jerk.
  config.viability = 19;
  config.limits = test::PandaLimits();
  for (double& jerk : config.limits.dddq_max) jerk /= 2;
  CommandChain chain(config, CommandInterface::kJointPosition);
  chain.Reset(state);
  RobotCommand command;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_NEAR(command.q_c[0], test::PandaLimits().dddq_max[0] / 2 * 1e-9, 1e-11);
  EXPECT_EQ(chain.kept_back(), 1U);
  EXPECT_EQ(chain.changed_joints(), 0b1111111);
  target.joint.q = state.q_d;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_EQ(command.q_c, state.q_d) << "an admissible command passes";
  EXPECT_EQ(chain.kept_back(), 1U);
  chain.Reset(state);
  EXPECT_EQ(chain.kept_back(), 0U);
}

TEST(CommandChainTest, TellsTheMarginOfTheStateAnsweredBehindTheViabilityFilter) {
  TickConfig config = Raw();
  RobotState state;
  state.q_d = {0, 0, 0, -1.5, 0, 1.5, 0};
  Target target;
  target.joint.q = state.q_d;
  const auto margin = [&] {
    CommandChain chain(config, CommandInterface::kJointPosition);
    chain.Reset(state);
    RobotCommand command;
    chain.Next(state, target, true, 1, {}, command);
    EXPECT_EQ(chain.changed_joints(), 0);
    return chain.margin();
  };
  EXPECT_FALSE(margin().has_value()) << "no filter";
  config.viability = 19;
  config.limits = test::PandaLimits();
  const reference::ViabilityFilter filter(config.limits, 19);
  EXPECT_EQ(margin(), filter.Margin(state.q_d, state.dq_d, state.ddq_d));
}

TEST(CommandChainTest, TheViabilityFilterRefusesTorques) {
  TickConfig config = Raw();
  config.viability = 19;
  config.limits = test::PandaLimits();
  EXPECT_THROW(CommandChain(config, CommandInterface::kTorque), InputError);
}

TEST(CommandChainTest, TheViabilityFilterOfPosesKeepsTheJerkOfTheEndEffector) {
  TickConfig config = Raw();
  config.viability = 19;
  config.limits = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  CommandChain chain(config, CommandInterface::kCartesianPose);
  RobotState state;
  state.q_d = {0, 0, 0, -1.5, 0, 1.5, 0};
  state.O_T_EE_c = model::ArmModel::Panda().Pose(model::Frame::kFlange, state.q_d);
  chain.Reset(state);
  Target target;
  target.pose.O_T_EE = state.O_T_EE_c;
  RobotCommand command;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_EQ(command.O_T_EE_c, state.O_T_EE_c) << "an admissible command passes";
  EXPECT_EQ(chain.kept_back(), 0U);
  target.pose.O_T_EE[12] += 0.1;
  chain.Next(state, target, true, 1, {}, command);
  // 1e-9 J from rest, where no joint has to be faster for it than it may.
  const double most = config.cartesian.translation.dddp_max * 1e-9;
  const double step = command.O_T_EE_c[12] - state.O_T_EE_c[12];
  EXPECT_GT(step, 0);
  EXPECT_LE(step, most);
  EXPECT_EQ(chain.kept_back(), 1U);
}

TEST(CommandChainTest, TheLimiterStandsBehindTheLowPass) {
  TickConfig config = Raw();
  config.limiter = reference::ClientLimits::Of(test::PandaLimits(), test::PandaCartesianLimits());
  config.low_pass_hz = 100;
  Target target;
  target.joint.q.fill(1);
  const JointVector q_c = After(config, CommandInterface::kJointPosition, {}, target).q_c;
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(q_c[i], config.limiter->dddq_max[i] * 1e-9, 1e-12) << "one cycle of full jerk";
  }
}

TEST(CommandChainTest, LimitsATorqueStepToTheTorqueRate) {
  TickConfig config = Raw();
  config.limiter = reference::ClientLimits::Of(test::PandaLimits(), test::PandaCartesianLimits());
  Target target;
  target.tau_J_d.fill(-50);
  const JointVector tau = After(config, CommandInterface::kTorque, {}, target).tau_J_d;
  EXPECT_NEAR(tau[0], -0.999999, 1e-9);
}

TEST(CommandChainTest, ArrivesWhenThePoseIsReachedAtRest) {
  TickConfig config;
  config.generator = Generator::kCartesian;
  CommandChain chain(config, CommandInterface::kCartesianPose);
  RobotState state;
  chain.Reset(state);
  Target target;
  RobotCommand command;
  target.pose.O_T_EE[12] = 0.01;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_FALSE(chain.Finish(state, false, command));
  state.O_T_EE_c = target.pose.O_T_EE;
  EXPECT_TRUE(chain.Finish(state, false, command));
  target.pose.O_dP_EE[2] = 0.1;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_FALSE(chain.Finish(state, false, command));
}

TEST(CommandChainTest, StatesThatCannotBeAnsweredDoNotMoveThePlayTime) {
  // Two of three cycles in a row without an answer, now and then, as when a state comes late: the
  // source of 1 rad/s is played evenly all the same.
  TickConfig config;
  config.generator = Generator::kRejoining;
  config.limits = test::PandaLimits();
  CommandChain chain(config, CommandInterface::kJointPosition);
  RobotState state;
  state.dq_d[0] = 1;
  chain.Reset(state);
  Target target;
  double largest = 0;
  for (std::int64_t k = 1; k < 3000; ++k) {
    const std::uint64_t cycles = k % 100 == 3 ? 3 : 1;
    if (k % 100 == 1 || k % 100 == 2) {  // the robot goes on
      state.q_d[0] += kCycleSeconds * state.dq_d[0];
      continue;
    }
    target.joint.q[0] = kCycleSeconds * static_cast<double>(k);
    RobotCommand command;
    chain.Next(state, target, true, cycles, Time(k * kCycle), command);
    const double dq = (command.q_c[0] - state.q_d[0]) / kCycleSeconds;
    state.ddq_d[0] = (dq - state.dq_d[0]) / kCycleSeconds;
    state.dq_d[0] = dq;
    state.q_d[0] = command.q_c[0];
    if (k > 1000) largest = std::max(largest, std::abs(dq - 1));
  }
  EXPECT_LT(largest, 1e-3);
}

TEST(CommandChainTest, ArrivesBehindTheViabilityFilterOnlyAtRest) {
  TickConfig config = Raw();
  config.viability = 19;
  config.limits = test::PandaLimits();
  CommandChain chain(config, CommandInterface::kJointPosition);
  RobotState state;
  state.q_d = {0, 0, 0, -1.5, 0, 1.5, 0};
  chain.Reset(state);
  Target target;
  target.joint.q = state.q_d;
  RobotCommand command;
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_TRUE(chain.Finish(state, false, command));
  state.dq_d[0] = 0.5;  // it passes its target
  chain.Next(state, target, true, 1, {}, command);
  EXPECT_FALSE(chain.Finish(state, false, command));
}

/// The command that finishes a motion 50 urad from its target, behind the viability filter.
RobotCommand FinishingCommand(CommandInterface interface, const RobotState& state) {
  TickConfig config = Raw();
  config.viability = 22;
  config.limits = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  CommandChain chain(config, interface);
  chain.Reset(state);
  Target target;
  target.joint.q = state.q_d;
  target.joint.q[1] -= 5e-5;
  target.pose.O_T_EE = state.O_T_EE_c;
  target.pose.O_T_EE[12] += 5e-5;
  RobotCommand command;
  for (int i = 0; i < 100; ++i) chain.Next(state, target, true, 1, {}, command);
  EXPECT_TRUE(chain.Finish(state, false, command));
  return command;
}

TEST(CommandChainTest, TheLastCommandIsOneFromWhichTheReferenceCanStandStill) {
  // From the filter's step towards the target a stop at once needs more than the limit of jerk
  // (world 167652 of the campaign).
  RobotState state;
  state.q_d = {0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
  state.dq_d[1] = -8e-4;
  state.ddq_d[1] = -0.6;
  EXPECT_EQ(FinishingCommand(CommandInterface::kJointPosition, state).q_c, state.q_d);
  EXPECT_EQ(FinishingCommand(CommandInterface::kJointVelocity, state).dq_c, JointVector{});
  state.dq_d = state.ddq_d = {};
  state.O_dP_EE_c[0] = 8e-4;
  state.O_ddP_EE_c[0] = 0.6;
  EXPECT_EQ(FinishingCommand(CommandInterface::kCartesianPose, state).O_T_EE_c, state.O_T_EE_c);
}

TEST(CommandChainTest, RefusesAGeneratorOfAnotherInterface) {
  TickConfig joint;
  TickConfig cartesian;
  cartesian.generator = Generator::kCartesian;
  for (const auto interface : {CommandInterface::kJointVelocity, CommandInterface::kTorque,
                               CommandInterface::kCartesianPose}) {
    EXPECT_THROW(CommandChain(joint, interface), InputError);
  }
  for (const auto interface : {CommandInterface::kJointVelocity, CommandInterface::kTorque,
                               CommandInterface::kJointPosition}) {
    EXPECT_THROW(CommandChain(cartesian, interface), InputError);
  }
}

TEST(CommandChainTest, RefusesNumbersOutOfRangeByName) {
  const auto refused = [](auto change) {
    TickConfig config;
    change(config);
    try {
      config.Validate(CommandInterface::kJointPosition);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refused([](TickConfig& c) { c.low_pass_hz = 0; }).find("low_pass_hz"),
            std::string::npos);
  EXPECT_NE(refused([](TickConfig& c) { c.lambda = 2; }).find("lambda"), std::string::npos);
  EXPECT_NE(refused([](TickConfig& c) {
              c.period_tolerance = std::chrono::milliseconds(-1);
            }).find("period_tolerance"),
            std::string::npos);
}

TEST(IsValidTest, KnowsWhatMustNotBeSent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RobotCommand command;
  EXPECT_TRUE(IsValid(command, CommandInterface::kJointPosition));
  command.q_c[6] = nan;
  EXPECT_FALSE(IsValid(command, CommandInterface::kJointPosition));
  command.dq_c[0] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(IsValid(command, CommandInterface::kJointVelocity));
  command.tau_J_d[3] = nan;
  EXPECT_FALSE(IsValid(command, CommandInterface::kTorque));

  command.O_T_EE_c = kIdentityTransform;
  EXPECT_TRUE(IsValid(command, CommandInterface::kCartesianPose));
  command.O_T_EE_c[0] = 1 + 0.9e-5;
  EXPECT_TRUE(IsValid(command, CommandInterface::kCartesianPose));
  command.O_T_EE_c[0] = 1 + 2e-5;
  EXPECT_FALSE(IsValid(command, CommandInterface::kCartesianPose));
  command.O_T_EE_c = kIdentityTransform;
  command.O_T_EE_c[3] = 1e-12;
  EXPECT_FALSE(IsValid(command, CommandInterface::kCartesianPose)) << "the last row is exact";
  command.O_T_EE_c = kIdentityTransform;
  command.O_T_EE_c[14] = nan;
  EXPECT_FALSE(IsValid(command, CommandInterface::kCartesianPose));
}

TEST(CommandChainTest, AllocatesNothingOnAnyInterface) {
  for (const auto interface : {CommandInterface::kJointPosition, CommandInterface::kJointVelocity,
                               CommandInterface::kCartesianPose, CommandInterface::kTorque}) {
    TickConfig config = Raw();
    config.low_pass_hz = 100;
    config.limiter = reference::ClientLimits::Of(test::PandaLimits(), test::PandaCartesianLimits());
    config.source_rate_hz = 125;
    config.limits = test::PandaLimits();
    config.cartesian = test::PandaCartesianLimits();
    if (interface != CommandInterface::kTorque) config.viability = 19;
    CommandChain chain(config, interface);
    RobotState state;
    Target target;
    RobotCommand command;
    const test::RealtimeGuard guard;
    chain.Reset(state);
    for (int k = 0; k < 2000; ++k) {
      target.joint.q[0] = target.tau_J_d[0] = target.pose.O_T_EE[12] = 1e-4 * k;
      chain.Next(state, target, k % 8 == 0, 1, {}, command);
    }
    EXPECT_EQ(guard.allocations(), 0);
  }
}

}  // namespace
}  // namespace twin::loop::loop_command_chain_test
