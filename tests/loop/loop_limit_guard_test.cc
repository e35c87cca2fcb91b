#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"
#include "twin/loop/command_chain.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/limit_monitor.h"
#include "twin/onboard/motion_generator.h"

namespace twin::loop::loop_limit_guard_test {
namespace {

using control::CommandInterface;
using model::ArmModel;
using model::Frame;
using onboard::JointReference;
using onboard::LimitKind;

constexpr JointVector kReady{0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398};

Vector3 EndEffector(const JointVector& q) {
  const Transform T = ArmModel::Panda().Pose(Frame::kEndEffector, q);
  return {T[12], T[13], T[14]};
}

/// The end effector stays within 0.1 m of where it is at the ready pose, in x, y and z.
model::LabLimits Box() {
  constexpr double kHalf = 0.1;
  const Vector3 centre = EndEffector(kReady);
  model::LimitBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] = centre[i] - kHalf;
    box.high[i] = centre[i] + kHalf;
  }
  model::LabLimits limits;
  limits.regions.push_back(
      {.name = "box", .parts = {model::LimitedPart::kEndEffector}, .shape = box});
  return limits;
}

/// Distance of the end effector from the box's border; negative outside.
double Inside(const JointVector& q) {
  const model::LabLimits limits = Box();
  const auto& box = std::get<model::LimitBox>(limits.regions[0].shape);
  const Vector3 p = EndEffector(q);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min({least, p[i] - box.low[i], box.high[i] - p[i]});
  }
  return least;
}

TickConfig Config(const std::optional<model::LabLimits>& lab) {
  TickConfig config;
  config.generator = Generator::kNone;
  config.rate_matching = false;
  config.viability = 0;  // makes any stream a legal one
  config.limits = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  config.lab = lab;
  return config;
}

/// What a stream did to an ideal robot.
struct Outcome {
  bool legal = true;   ///< to INT's checks of commands
  double least = 0.1;  ///< distance from the border, in every cycle
  std::optional<onboard::BrokenLimit> breach;
  bool rests = false;  ///< at the end
};

/// A random stream of joint targets, or of velocities: new ones at random times.
struct RandomStream {
  std::uint64_t seed;
  CommandInterface interface;

  [[nodiscard]] reference::Target At(int cycle) const {
    const Random random(seed, twin::RandomStream::kTest);
    const std::uint64_t part = static_cast<std::uint64_t>(cycle) / 150;
    reference::Target target;
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      const double x = 2 * random.Uniform(part, i) - 1;
      target.joint.q[i] = kReady[i] + 0.5 * x;
      target.joint.dq[i] =
          interface == CommandInterface::kJointVelocity ? x * test::PandaLimits().dq_max[i] : 0;
    }
    return target;
  }
};

RobotState StateOf(const JointReference& reference, std::uint64_t id) {
  RobotState state;
  state.message_id = id;
  state.q_d = state.q = reference.q_d;
  state.dq_d = state.dq = reference.dq_d;
  state.ddq_d = reference.ddq_d;
  return state;
}

Outcome Play(const RandomStream& stream, const std::optional<model::LabLimits>& lab) {
  CommandChain chain(Config(lab), stream.interface);
  JointReference reference = JointReference::Rest(kReady);
  chain.Reset(StateOf(reference, 1));
  Outcome outcome;
  for (int cycle = 0; cycle < 1500 && !chain.stopped(); ++cycle) {
    RobotCommand command;
    const RobotState state = StateOf(reference, 1 + static_cast<std::uint64_t>(cycle));
    chain.Next(state, stream.At(cycle), true, 1, {}, command);
    reference = stream.interface == CommandInterface::kJointPosition
                    ? reference.AfterPosition(command.q_c)
                    : reference.AfterVelocity(command.dq_c);
    const bool legal = onboard::CheckStep(reference, test::PandaLimits(), 1).empty();
    outcome.legal = outcome.legal && legal;
    outcome.least = std::min(outcome.least, Inside(reference.q_d));
  }
  outcome.breach = chain.breach();
  outcome.rests = chain.stopped();
  return outcome;
}

class LimitGuardTest : public ::testing::TestWithParam<CommandInterface> {};

TEST_P(LimitGuardTest, NoStreamLeavesTheRegionAndEveryStopIsLegal) {
  int stopped = 0;
  double closest = 1;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Outcome outcome = Play({seed, GetParam()}, Box());
    ASSERT_TRUE(outcome.legal) << "seed " << seed;
    ASSERT_GE(outcome.least, 0) << "seed " << seed;
    if (!outcome.breach) continue;
    ++stopped;
    ASSERT_TRUE(outcome.rests) << "seed " << seed;
    if (outcome.breach->kind == LimitKind::kRegion) closest = std::min(closest, outcome.least);
  }
  EXPECT_GT(stopped, 30);
  EXPECT_LT(closest, 0.01);  // the proof does not keep far away
}

TEST_P(LimitGuardTest, WithoutTheProofTheSameStreamsLeaveTheRegion) {
  int left = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    left += Play({seed, GetParam()}, std::nullopt).least < 0 ? 1 : 0;
  }
  EXPECT_GT(left, 5);
}

TEST_P(LimitGuardTest, AllocatesNothing) {
  CommandChain chain(Config(Box()), GetParam());
  JointReference reference = JointReference::Rest(kReady);
  chain.Reset(StateOf(reference, 1));
  RobotCommand command;
  const test::RealtimeGuard guard;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    chain.Next(StateOf(reference, 1), RandomStream{3, GetParam()}.At(cycle), true, 1, {}, command);
    reference = GetParam() == CommandInterface::kJointPosition
                    ? reference.AfterPosition(command.q_c)
                    : reference.AfterVelocity(command.dq_c);
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_TRUE(chain.breach());
}

INSTANTIATE_TEST_SUITE_P(JointInterfaces, LimitGuardTest,
                         ::testing::Values(CommandInterface::kJointPosition,
                                           CommandInterface::kJointVelocity),
                         [](const auto& info) {
                           return info.param == CommandInterface::kJointPosition ? "Positions"
                                                                                 : "Velocities";
                         });

/// Moves the pose of the end effector along y at a constant acceleration.
TEST(LimitGuardPosesTest, TheRobotsOwnStopKeepsTheRegionWhenItActsInTime) {
  const onboard::GeneratorLimits limits{.joints = test::PandaLimits(),
                                        .cartesian = test::PandaCartesianLimits()};
  onboard::MotionGenerator robot(limits, kReady);
  robot.Start({.generator = MotionGeneratorMode::kCartesianPosition});
  CommandChain chain(Config(Box()), CommandInterface::kCartesianPose);
  Transform pose = robot.O_T_EE_d();
  double v = 0;
  double least = 1;
  const auto state = [&](std::uint64_t id) {
    RobotState now = StateOf(robot.joints(), id);
    now.O_T_EE_c = robot.cartesian().O_T_EE_c;
    now.O_dP_EE_c = robot.cartesian().O_dP_EE_c;
    now.O_ddP_EE_c = robot.cartesian().O_ddP_EE_c;
    return now;
  };
  chain.Reset(state(1));
  for (std::uint64_t id = 1; id < 1000; ++id) {
    v += 1e-3;  // 1 m/s^2
    pose[13] += 1e-3 * v;
    reference::Target target;
    target.pose.O_T_EE = pose;
    RobotCommand command;
    chain.Next(state(id), target, true, 1, {}, command);
    if (chain.breach()) break;
    ASSERT_TRUE(robot.Take(command, id == 1, id).empty());
    least = std::min(least, Inside(robot.joints().q_d));
  }
  ASSERT_TRUE(chain.breach());
  EXPECT_FALSE(chain.sends());
  EXPECT_TRUE(chain.stopped());
  for (int held = 0; held < 5; ++held) {
    ASSERT_TRUE(robot.Hold(2).empty());
    least = std::min(least, Inside(robot.joints().q_d));
  }
  while (!robot.AtRest()) {
    robot.Brake();
    least = std::min(least, Inside(robot.joints().q_d));
  }
  EXPECT_GE(least, 0);
  EXPECT_LT(least, 0.01);
}

TEST(LimitGuardForceTest, AForceAboveItsCapBeginsTheStop) {
  model::LabLimits lab;
  lab.force_max = 20;
  CommandChain chain(Config(lab), CommandInterface::kJointPosition);
  JointReference moving = JointReference::Rest(kReady);
  moving.dq_d[0] = 0.1;
  RobotState state = StateOf(moving, 1);
  chain.Reset(state);
  reference::Target on;
  on.joint.q = moving.AfterLoss().q_d;
  RobotCommand command;
  state.O_F_ext_hat_K = {12, 16, 0, 0, 0, 0};  // 20 N
  chain.Next(state, on, true, 1, {}, command);
  EXPECT_FALSE(chain.breach());
  state.O_F_ext_hat_K[2] = 1;
  chain.Next(state, on, true, 1, {}, command);
  ASSERT_TRUE(chain.breach());
  EXPECT_EQ(chain.breach()->kind, LimitKind::kForce);
  EXPECT_NEAR(chain.breach()->value, std::sqrt(401), 1e-12);
  EXPECT_LT(command.q_c[0], on.joint.q[0]);
}

test::LockstepMotion Motion() {
  using std::chrono::microseconds;
  test::LockstepMotion motion;
  motion.tick.cost = faults::DelayModel(faults::LogNormalDelay{microseconds(13), 0.4, {}});
  motion.controller_loop.cost = faults::DelayModel(faults::ConstantDelay{microseconds(200)});
  motion.tick.limits = test::PandaLimits();
  return motion;
}

TEST(LimitGuardLockstepTest, AMotionEndsWithTheLimitItsValueAndItsBound) {
  // Joint 7 swings by 0.3 rad in 1 s, at up to 1.6 rad/s.
  test::Swing swing;
  test::LockstepMotion motion = Motion();
  motion.tick.lab.emplace().dq_max = JointVector{1, 1, 1, 1, 1, 1, 0.4};
  test::Keeper keeper;
  const RunReport report = motion.Run(swing, 1, &keeper);
  ASSERT_TRUE(report.limit) << report.failure;
  EXPECT_EQ(report.limit->kind, LimitKind::kJointSpeed);
  EXPECT_EQ(report.limit->axis, 6);
  EXPECT_GT(std::abs(report.limit->value), 0.4);
  EXPECT_NE(report.failure.find("lab_limit: limit speed.joints: joint 7"), std::string::npos)
      << report.failure;
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_TRUE(report.errors.none());
  EXPECT_FALSE(report.succeeded());
  for (const record::CycleRecord& cycle : keeper.cycles) {
    ASSERT_LE(std::abs(cycle.state.dq_d[6]), 0.4);
  }
  const auto limited =
      std::ranges::count(keeper.ticks, record::TickAction::kLimited, &record::TickRecord::action);
  EXPECT_GT(limited, 10);  // 0.4 rad/s at 20 rad/s^2
}

TEST(LimitGuardLockstepTest, AMotionWithinTheLimitsIsNotChanged) {
  test::Swing swing;
  test::LockstepMotion free = Motion();
  test::LockstepMotion limited = free;
  limited.tick.lab = Box();
  test::Keeper a;
  test::Keeper b;
  EXPECT_EQ(free.Run(swing, 1, &a).failure, "");
  EXPECT_EQ(limited.Run(swing, 1, &b).failure, "");
  ASSERT_EQ(a.cycles.size(), b.cycles.size());
  for (std::size_t i = 0; i < a.cycles.size(); ++i) {
    ASSERT_EQ(a.cycles[i].state.q_d, b.cycles[i].state.q_d);
  }
}

}  // namespace
}  // namespace twin::loop::loop_limit_guard_test
