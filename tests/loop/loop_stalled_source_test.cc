// A source that stops giving targets while the arm moves, behind each chain.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/loop/command_chain.h"

namespace twin::loop::loop_stalled_source_test {
namespace {

using control::CommandInterface;

constexpr double kT = kCycleSeconds;
constexpr double kSpeed = 1;  // rad/s, of joint 1

/// Joint 1's reference as the robot forms it, and the largest shares of its limits.
class Reference {
 public:
  RobotState state;
  double acceleration = 0;
  double jerk = 0;

  void Take(double dq) {
    const JointLimits limits = test::PandaLimits();
    const double ddq = (dq - state.dq_d[0]) / kT;
    acceleration = std::max(acceleration, std::abs(ddq) / limits.ddq_max[0]);
    jerk = std::max(jerk, std::abs(ddq - state.ddq_d[0]) / kT / limits.dddq_max[0]);
    state.q_d[0] += kT * dq;
    state.dq_d[0] = dq;
    state.ddq_d[0] = ddq;
  }
};

/// A source of positions or velocities at 1 kHz that moves evenly for a second and then stalls.
class Stall {
 public:
  Stall(const TickConfig& config, CommandInterface interface)
      : chain_(config, interface), interface_(interface) {
    robot.state.dq_d[0] = kSpeed;
    chain_.Reset(robot.state);
    target_.joint.dq[0] = kSpeed;
  }

  void Run(int cycles, bool stalls) {
    for (int i = 0; i < cycles; ++i) {
      ++k_;
      if (!stalls) target_.joint.q[0] = kSpeed * kT * k_;
      RobotCommand command;
      chain_.Next(robot.state, target_, !stalls, 1, Time(k_ * kCycle), command);
      robot.Take(interface_ == CommandInterface::kJointVelocity
                     ? command.dq_c[0]
                     : (command.q_c[0] - robot.state.q_d[0]) / kT);
    }
  }
  [[nodiscard]] double last_target() const { return target_.joint.q[0]; }
  [[nodiscard]] const CommandChain& chain() const { return chain_; }

  Reference robot;

 private:
  CommandChain chain_;
  CommandInterface interface_;
  reference::Target target_;
  int k_ = 0;
};

TickConfig Config(Generator generator, bool viability) {
  TickConfig config;
  config.generator = generator;
  config.limits = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  if (viability) config.viability = 19;
  return config;
}

TEST(StalledSourceTest, CountsAsStalledAfterTheStallTime) {
  TickConfig config = Config(Generator::kRejoining, true);
  config.stall_time = std::chrono::milliseconds(30);
  Stall stall(config, CommandInterface::kJointPosition);
  stall.Run(1000, false);
  stall.Run(30, true);
  EXPECT_FALSE(stall.chain().stalled());
  EXPECT_NEAR(stall.robot.state.dq_d[0], kSpeed, 1e-9) << "the motion goes on until then";
  stall.Run(1, true);
  EXPECT_TRUE(stall.chain().stalled());
  stall.Run(1, false);
  EXPECT_FALSE(stall.chain().stalled());
}

TEST(StalledSourceTest, ThreePeriodsOfASlowSourceAreNoStall) {
  TickConfig config = Config(Generator::kRejoining, true);
  config.source_rate_hz = 50;
  Stall stall(config, CommandInterface::kJointPosition);
  stall.Run(100, false);
  stall.Run(60, true);
  EXPECT_FALSE(stall.chain().stalled());
  stall.Run(1, true);
  EXPECT_TRUE(stall.chain().stalled());
}

TEST(StalledSourceTest, TheCorrectionLeadsToTheLastTargetWithinTheLimits) {
  Stall stall(Config(Generator::kRejoining, true), CommandInterface::kJointPosition);
  stall.Run(1000, false);
  stall.robot.acceleration = stall.robot.jerk = 0;
  // 20 ms of motion, 75 ms of braking, and the way back; 13 mrad are left of it after 200 ms.
  stall.Run(300, true);
  EXPECT_NEAR(stall.robot.state.q_d[0], stall.last_target(), 2e-3);
  stall.Run(200, true);
  EXPECT_NEAR(stall.robot.state.q_d[0], stall.last_target(), 1e-6);
  EXPECT_NEAR(stall.robot.state.dq_d[0], 0, 1e-4);
  EXPECT_LE(stall.robot.acceleration, 1);
  EXPECT_LE(stall.robot.jerk, 1);
}

TEST(StalledSourceTest, OneThatReturnsIsRejoinedWithinTheLimits) {
  Stall stall(Config(Generator::kRejoining, true), CommandInterface::kJointPosition);
  stall.Run(1000, false);
  stall.robot.acceleration = stall.robot.jerk = 0;
  stall.Run(200, true);
  stall.Run(600, false);
  EXPECT_NEAR(stall.robot.state.q_d[0], stall.last_target() - 2.25 * kT * kSpeed, 1e-3);
  EXPECT_LE(stall.robot.acceleration, 1);
  EXPECT_LE(stall.robot.jerk, 1);
}

TEST(StalledSourceTest, AVelocityDecaysAndMakesUpForNoWay) {
  for (const auto generator : {Generator::kRejoining, Generator::kNone}) {
    Stall stall(Config(generator, false), CommandInterface::kJointVelocity);
    stall.Run(1000, false);
    stall.robot.acceleration = stall.robot.jerk = 0;
    const double begin = stall.robot.state.q_d[0];
    stall.Run(300, true);
    EXPECT_NEAR(stall.robot.state.dq_d[0], 0, 1e-4);
    // 20 ms of motion, and braking by 0.9 of the limit, with what jerk and the last part add.
    const double braking = kSpeed * kSpeed / (2 * 0.9 * test::PandaLimits().ddq_max[0]);
    EXPECT_GT(stall.robot.state.q_d[0], begin + 0.02 + braking);
    EXPECT_LT(stall.robot.state.q_d[0], begin + 0.02 + 1.5 * braking);
    EXPECT_LE(stall.robot.acceleration, 0.91);
    EXPECT_LE(stall.robot.jerk, 0.41);
  }
}

TEST(StalledSourceTest, BehindThePapersLawTheVelocityDecaysAndLambdaLeadsBack) {
  Stall stall(Config(Generator::kJoint, false), CommandInterface::kJointPosition);
  stall.Run(1000, false);
  stall.robot.acceleration = stall.robot.jerk = 0;
  stall.Run(200, true);
  EXPECT_LE(stall.robot.acceleration, 1);
  EXPECT_LE(stall.robot.jerk, 0.5);
  const double ahead = stall.robot.state.q_d[0] - stall.last_target();
  stall.Run(1000, true);
  EXPECT_NEAR(stall.robot.state.q_d[0] - stall.last_target(), ahead * std::pow(1 - 1e-3, 1000),
              1e-9);
}

TEST(StalledSourceTest, ATorqueDecaysBelowTheRobotsTorqueRate) {
  CommandChain chain(Config(Generator::kNone, false), CommandInterface::kTorque);
  RobotState state;
  chain.Reset(state);
  reference::Target target;
  target.tau_J_d[0] = 87;
  RobotCommand command;
  chain.Next(state, target, true, 1, {}, command);
  double last = command.tau_J_d[0];
  for (int k = 0; k < 520; ++k) {
    chain.Next(state, target, false, 1, {}, command);
    EXPECT_LE(std::abs(command.tau_J_d[0] - last), test::PandaLimits().dtau_max[0] * kT);
    last = command.tau_J_d[0];
  }
  EXPECT_NEAR(last, 87 * std::pow(0.99, 500), 1e-9);
}

}  // namespace
}  // namespace twin::loop::loop_stalled_source_test
