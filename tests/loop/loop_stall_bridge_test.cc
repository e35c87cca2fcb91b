// The stall bridge where it works: in the command chain, in front of a robot that takes or misses
// its commands.
#include "twin/loop/stall_bridge.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/loop/command_chain.h"

namespace twin::loop {
namespace {

using control::CommandInterface;
using reference::Target;

constexpr double kT = kCycleSeconds;

/// The robot's reference, by backward differences, and its largest acceleration and jerk as shares
/// of the limits.
class Reference {
 public:
  explicit Reference(const Target& start) {
    state.q_d = start.joint.q;
    state.dq_d = start.joint.dq;
    state.tau_J_d = start.tau_J_d;
  }

  void TakePosition(const JointVector& q_c) {
    for (std::size_t i = 0; i < kJoints; ++i) Take(i, (q_c[i] - state.q_d[i]) / kT);
    state.q_d = q_c;
  }
  void TakeVelocity(const JointVector& dq_c) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      Take(i, dq_c[i]);
      state.q_d[i] += kT * dq_c[i];
    }
  }
  void TakeTorque(const JointVector& tau) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      torque_rate = std::max(torque_rate, std::abs(tau[i] - state.tau_J_d[i]) / kT);
    }
    state.tau_J_d = tau;
  }
  /// No command: the acceleration is held.
  void Miss() {
    for (std::size_t i = 0; i < kJoints; ++i) {
      state.dq_d[i] += kT * state.ddq_d[i];
      state.q_d[i] += kT * state.dq_d[i];
    }
  }

  RobotState state;
  double acceleration = 0;
  double jerk = 0;
  double torque_rate = 0;

 private:
  void Take(std::size_t i, double dq) {
    const double ddq = (dq - state.dq_d[i]) / kT;
    acceleration = std::max(acceleration, std::abs(ddq) / limits_.ddq_max[i]);
    jerk = std::max(jerk, std::abs(ddq - state.ddq_d[i]) / kT / limits_.dddq_max[i]);
    state.dq_d[i] = dq;
    state.ddq_d[i] = ddq;
  }

  JointLimits limits_ = test::PandaLimits();
};

using Source = std::function<Target(double t)>;

/// All joints at a constant speed.
Source AtSpeed(double speed) {
  return [speed](double t) {
    Target target;
    target.joint.q.fill(speed * t);
    target.joint.dq.fill(speed);
    return target;
  };
}

/// All joints at 0.5 rad/s and 1.5 rad/s^2 at time 0: 0.2 of joint 2's limit, the generator's
/// promise.
Target Accelerating(double t) {
  Target target;
  target.joint.q.fill(0.5 * t + 0.75 * t * t);
  target.joint.dq.fill(0.5 + 1.5 * t);
  return target;
}

/// A source at 1 kHz in front of the chain, with one lapse or with many.
struct Course {
  Source source = AtSpeed(1);
  CommandInterface interface = CommandInterface::kJointPosition;
  int cycles = 6000;
  int lapse_begin = 1000;  ///< cycle
  int every = 0;           ///< cycles after which another lapse begins; 0: it is the only one
  int stalled = 0;         ///< cycles from there without a deposit
  int missed = 0;          ///< cycles from there in which the robot gets no command
  double leap = 0;         ///< s by which the robot's time falls behind the source's, there

  Reference Run() const {
    TickConfig config;
    if (interface != CommandInterface::kJointPosition) config.generator = Generator::kNone;
    CommandChain chain(config, interface);
    Reference robot(source(0));
    chain.Reset(robot.state);
    Target target;
    Time source_time{};
    std::uint64_t waiting = 0;
    bool fresh = false;
    for (int k = 1; k <= cycles; ++k) {
      const bool lapsed = k >= lapse_begin;
      const int since = every > 0 ? (k - lapse_begin) % every : k - lapse_begin;
      const double t = k * kT + (lapsed ? leap : 0);
      if (!lapsed || since >= stalled) {
        target = source(t);
        source_time = Time(FromSeconds(t));
        fresh = true;
      }
      ++waiting;
      if (lapsed && since < missed) {
        robot.Miss();
        continue;
      }
      RobotCommand command;
      chain.Next(robot.state, target, fresh, waiting, source_time, command);
      fresh = false;
      waiting = 0;
      switch (interface) {
        case CommandInterface::kTorque: robot.TakeTorque(command.tau_J_d); break;
        case CommandInterface::kJointVelocity: robot.TakeVelocity(command.dq_c); break;
        default: robot.TakePosition(command.q_c);
      }
    }
    return robot;
  }
};

/// A slow source behind generator and low-pass, every command taken.
struct LowPassCourse {
  static constexpr int kCycles = 200;

  explicit LowPassCourse(const TickConfig& config) {
    CommandChain chain(config, CommandInterface::kJointPosition);
    Reference robot{Target()};
    chain.Reset(robot.state);
    for (int k = 1; k <= kCycles; ++k) {
      RobotCommand command;
      chain.Next(robot.state, AtSpeed(0.001)(k * kT), true, 1, Time(kCycle * k), command);
      robot.TakePosition(command.q_c);
    }
    q_d = robot.state.q_d;
  }

  JointVector q_d{};
};

void ExpectWithinLimits(const Reference& robot) {
  EXPECT_LT(robot.acceleration, 1);
  EXPECT_LT(robot.jerk, 1);
}

TEST(StallBridgeTest, LeavesASourceInTimeAlone) {
  StallBridge bridge(CommandInterface::kJointPosition, 1);
  for (int k = 0; k < 1000; ++k) {
    // Every other deposit consumed twice, the next one skipped: two free-running loops.
    bridge.Observe(k % 2 == 0, 1, Time(kCycle * (k - k % 2)), 0);
    EXPECT_FALSE(bridge.active());
  }
}

TEST(StallBridgeTest, AStallOf200MillisecondsBreaksNoLimitAndTheSourceIsFoundAgain) {
  const Reference robot = Course{.stalled = 200}.Run();
  ExpectWithinLimits(robot);
  EXPECT_NEAR(robot.state.q_d[0], 6.0, 0.02) << "but for what the generator's 1 s leaves";
}

TEST(StallBridgeTest, NeitherDoesOneAtTheTopSpeedOfTheJoints) {
  ExpectWithinLimits(Course{.source = AtSpeed(2.175), .stalled = 200}.Run());
}

TEST(StallBridgeTest, ASourceThatNeverReturnsDecaysToItsLastTarget) {
  const Reference robot = Course{.cycles = 20000, .stalled = 100'000}.Run();
  ExpectWithinLimits(robot);
  EXPECT_NEAR(robot.state.q_d[0], 0.999, 1e-6);
}

TEST(StallBridgeTest, LapsesOfAllLengthsInAnAccelerationBreakNoLimit) {
  for (const int length : {2, 3, 4, 5, 6, 8, 12, 20, 50}) {
    SCOPED_TRACE(length);
    Course course{.source = &Accelerating, .cycles = 400, .lapse_begin = 150, .stalled = length};
    ExpectWithinLimits(course.Run());
    // Of the robot's time, of 3 cycles and more.
    course.stalled = 0;
    course.leap = (length + 1) * kT;
    ExpectWithinLimits(course.Run());
  }
}

TEST(StallBridgeTest, ALapseOfSourceAndLinkTogetherGoesOnFromWhereTheRobotIs) {
  // The communication stood still too: the robot has held its acceleration for eight cycles.
  ExpectWithinLimits(
      Course{.source = &Accelerating, .cycles = 400, .lapse_begin = 150, .stalled = 8, .missed = 8}
          .Run());
}

TEST(StallBridgeTest, CommandsThatTheRobotDidNotTakeAreNoticedInItsState) {
  // The robot holds a wrong acceleration over the lapse: it was in the middle of a correction.
  for (const int missed : {1, 2, 4, 8, 15}) {
    SCOPED_TRACE(missed);
    ExpectWithinLimits(
        Course{.source = &Accelerating, .cycles = 400, .lapse_begin = 150, .missed = missed}.Run());
  }
}

TEST(StallBridgeTest, ALoopThatAnswersEveryOtherStateIsNoLapse) {
  StallBridge bridge(CommandInterface::kJointPosition, 1);
  for (int k = 0; k < 1000; ++k) {
    bridge.Observe(true, 2, Time(2 * k * kCycle), 1);
    EXPECT_FALSE(bridge.active());
  }
}

TEST(StallBridgeTest, StagesBehindItAreNotTakenForALapse) {
  // What the robot takes is what the low-pass made of the demand: still the chain's own command.
  TickConfig config;
  config.low_pass_hz = 100;
  const LowPassCourse bridged(config);
  const reference::LowPass low_pass(config.low_pass_hz);
  const reference::JointReferenceGenerator generator(config.lambda);
  JointVector q_d{};
  for (int k = 1; k <= LowPassCourse::kCycles; ++k) {
    q_d = low_pass.Filter(generator.Next(q_d, AtSpeed(0.001)(k * kT).joint), q_d);
  }
  EXPECT_EQ(bridged.q_d, q_d);
}

TEST(StallBridgeTest, AFilterOfTheRobotsOwnIsNotTakenForALapse) {
  // The robot takes every command, and makes another value of it.
  const reference::LowPass filter(100);
  TickConfig config;
  config.generator = Generator::kNone;
  config.robot_shows_commands = false;
  CommandChain chain(config, CommandInterface::kJointVelocity);
  Reference robot{Target()};
  chain.Reset(robot.state);
  double expected = 0;
  for (int k = 1; k <= 500; ++k) {
    RobotCommand command;
    const double dq = std::min(2e-3 * k, 0.5);
    chain.Next(robot.state, AtSpeed(dq)(k * kT), true, 1, Time(kCycle * k), command);
    robot.TakeVelocity(filter.Filter(command.dq_c, robot.state.dq_d));
    expected = filter.Filter(dq, expected);
    ASSERT_NEAR(robot.state.dq_d[0], expected, 1e-9) << "cycle " << k;
  }
}

TEST(StallBridgeTest, AMotionIsNotFinishedWhileADifferenceIsLeft) {
  TickConfig config;
  config.generator = Generator::kNone;
  CommandChain chain(config, CommandInterface::kJointVelocity);
  Reference robot(AtSpeed(0.5)(0));
  chain.Reset(robot.state);
  RobotCommand command;
  chain.Next(robot.state, AtSpeed(0.5)(kT), true, 1, Time(kCycle), command);
  robot.TakeVelocity(command.dq_c);
  // Back from 50 ms without a deposit, the source is at rest and done; the robot is not.
  chain.Next(robot.state, Target(), true, 1, Time(50 * kCycle), command);
  EXPECT_FALSE(chain.Arrived(robot.state));
}

TEST(StallBridgeTest, LapsesWithoutEndDoNotLetTheReferenceRunAway) {
  // A lapse every few cycles, sooner and later than the bridge would be done with one.
  for (const CommandInterface interface :
       {CommandInterface::kJointPosition, CommandInterface::kJointVelocity,
        CommandInterface::kTorque}) {
    SCOPED_TRACE(static_cast<int>(interface));
    const auto sine = [](double t) {
      Target target;
      target.joint.q.fill(0.1 * (1 - std::cos(t)));
      target.joint.dq.fill(0.1 * std::sin(t));
      target.tau_J_d.fill(0.1 * std::sin(t));
      return target;
    };
    for (const int every : {5, 7, 9, 15, 30, 60, 100, 300}) {
      SCOPED_TRACE(every);
      const Reference robot = Course{.source = sine,
                                     .interface = interface,
                                     .cycles = 12'566,
                                     .every = every,
                                     .stalled = 4}
                                  .Run();
      ExpectWithinLimits(robot);
      EXPECT_LT(robot.torque_rate, 1000);
      EXPECT_NEAR(robot.state.tau_J_d[0], 0, 0.02);
      EXPECT_NEAR(robot.state.dq_d[0], 0, 0.05);
      if (interface == CommandInterface::kJointPosition) {
        EXPECT_NEAR(robot.state.q_d[0], 0, 0.05);
      }
    }
  }
}

TEST(StallBridgeTest, WithoutItsDetectionTheSameLapseBreaksThem) {
  // The same chain with a source that claims to be in time.
  Course course{.source = &Accelerating, .cycles = 400, .lapse_begin = 150, .leap = 0.02};
  CommandChain chain({}, CommandInterface::kJointPosition);
  Reference robot(Accelerating(0));
  chain.Reset(robot.state);
  for (int k = 1; k <= course.cycles; ++k) {
    RobotCommand command;
    const double t = k * kT + (k >= course.lapse_begin ? course.leap : 0);
    chain.Next(robot.state, Accelerating(t), true, 1, Time(kCycle * k), command);
    robot.TakePosition(command.q_c);
  }
  EXPECT_GT(robot.jerk, 1);
}

TEST(StallBridgeTest, AVelocitySourceIsItselfAgainAfterALapse) {
  const auto sine = [](double t) {
    Target target;
    target.joint.dq.fill(0.4 * std::sin(2 * M_PI * t));
    return target;
  };
  for (const int length : {3, 10, 200}) {
    const Reference robot = Course{.source = sine,
                                   .interface = CommandInterface::kJointVelocity,
                                   .cycles = 8250,
                                   .stalled = length}
                                .Run();
    ExpectWithinLimits(robot);
    EXPECT_DOUBLE_EQ(robot.state.dq_d[0], 0.4 * std::sin(2 * M_PI * 8.25));
  }
}

TEST(StallBridgeTest, ATorqueSourceIsItselfAgainSoonAfterALapse) {
  const auto sine = [](double t) {
    Target target;
    target.tau_J_d.fill(5 * std::sin(2 * M_PI * t));
    return target;
  };
  for (const int length : {3, 10, 200}) {
    const Reference robot = Course{.source = sine,
                                   .interface = CommandInterface::kTorque,
                                   .cycles = 2250,
                                   .stalled = length}
                                .Run();
    EXPECT_LT(robot.torque_rate, 1000);
    EXPECT_NEAR(robot.state.tau_J_d[0], 5, 1e-6);
  }
}

/// A torque law's chain in front of a robot that misses 3 of every `every` commands.
class TorqueCourse {
 public:
  explicit TorqueCourse(int every) : every_(every) { chain_.Reset(state_); }

  /// @returns what the robot drives with in cycle k, when the law demands this.
  double Next(int k, double demand) {
    Target target;
    target.tau_J_d.fill(demand);
    RobotCommand command;
    chain_.Next(state_, target, true, 1, Time(kCycle * k), command);
    if (k % every_ >= 3) {
      rate = std::max(rate, std::abs(command.tau_J_d[0] - state_.tau_J_d[0]) / kT);
      state_.tau_J_d = command.tau_J_d;
    }
    return state_.tau_J_d[0];
  }

  double rate = 0;  ///< largest, Nm/s

 private:
  static TickConfig Config() {
    TickConfig config;
    config.generator = Generator::kNone;
    return config;
  }

  const int every_;
  CommandChain chain_{Config(), CommandInterface::kTorque};
  RobotState state_;
};

TEST(StallBridgeTest, LapsesWithoutEndLeaveATorqueLawStable) {
  // A joint of 0.6 kg m^2 on 600 Nm/rad and 30 Nms/rad, 5 mrad off.
  for (const int every : {6, 8, 12, 25, 50}) {
    SCOPED_TRACE(every);
    TorqueCourse course(every);
    double q = 5e-3;
    double dq = 0;
    double most = 0;
    for (int k = 1; k <= 3000; ++k) {
      dq += kT * course.Next(k, -600 * q - 30 * dq) / 0.6;
      q += kT * dq;
      most = std::max(most, std::abs(q));
    }
    EXPECT_LT(most, 6e-3);
    EXPECT_LT(std::abs(q), 1e-5);
    EXPECT_LT(course.rate, 1000);
  }
}

TEST(StallBridgeTest, ALapseDoesNotTakeATorqueLawsNoiseForARise) {
  TorqueCourse course(100);
  for (int k = 1; k <= 1000; ++k) {
    const double noise = (k * 7919 % 11 - 5) * 4e-3;  // +-20 mNm
    EXPECT_NEAR(course.Next(k, noise), 0, 0.021) << k;
  }
}

TEST(StallBridgeTest, AStalledTorqueSourceDecaysToZeroWithinTheTorqueRate) {
  const auto constant = [](double) {
    Target target;
    target.tau_J_d.fill(80);
    return target;
  };
  const Reference robot = Course{.source = constant,
                                 .interface = CommandInterface::kTorque,
                                 .cycles = 5000,
                                 .stalled = 100'000}
                              .Run();
  EXPECT_LT(robot.torque_rate, 1000);
  EXPECT_EQ(robot.state.tau_J_d[0], 0);
}

TEST(StallBridgeTest, ALatePoseGoesOnFromTheRobotsOwn) {
  // 0.2 m/s along x and 0.5 rad/s about z; the demand is 1 mm and 10 mrad further on.
  StallBridge bridge(CommandInterface::kCartesianPose, 1);
  bridge.Observe(true, 1, Time(kCycle), 0);
  bridge.Observe(true, 1, Time(20 * kCycle), 0);
  ASSERT_TRUE(bridge.active());
  RobotState state;
  state.O_dP_EE_c = {0.2, 0, 0, 0, 0, 0.5};
  RobotCommand command;
  command.O_T_EE_c = {std::cos(0.01),
                      std::sin(0.01),
                      0,
                      0,
                      -std::sin(0.01),
                      std::cos(0.01),
                      0,
                      0,
                      0,
                      0,
                      1,
                      0,
                      1e-3,
                      0,
                      0,
                      1};
  bridge.Carry(state, command);
  // Of what is missing, 0.8 m/s and 9.5 rad/s, w^2 as jerk: w = 8 / 0.8 and 6 1/s.
  EXPECT_NEAR(command.O_T_EE_c[12], 0.2e-3 + 100 * 0.8e-9, 1e-12);
  EXPECT_NEAR(command.O_T_EE_c[1], std::sin(0.5e-3 + 36 * 9.5e-9), 1e-12);
}

TEST(StallBridgeTest, AllocatesNothing) {
  StallBridge bridge(CommandInterface::kJointPosition, 1);
  RobotState state;
  RobotCommand command;
  const test::RealtimeGuard guard;
  for (int k = 0; k < 10000; ++k) {
    bridge.Observe(k % 300 < 100, 1, Time(kCycle * k), 0);
    if (bridge.active()) bridge.Carry(state, command);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.locks, 0);
}

}  // namespace
}  // namespace twin::loop
