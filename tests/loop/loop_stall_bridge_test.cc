#include "twin/loop/stall_bridge.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/time.h"
#include "twin/reference/joint_reference_generator.h"

namespace twin::loop {
namespace {

using control::CommandInterface;
using reference::Target;

constexpr double kT = kCycleSeconds;
/// A source at 1 kHz; it counts as stalled after 5 cycles without a deposit.
constexpr std::uint64_t kPeriod = 1;
constexpr std::uint64_t kPatience = 5;

/// What the robot would see of a command stream: its largest acceleration and jerk as shares of the
/// limits, by backward differences from rest or from a given motion.
class Judge {
 public:
  /// @param dq  the motion so far, at constant velocity.
  explicit Judge(const JointVector& q, const JointVector& dq = {}) : q_(q), dq_(dq) {}

  void Take(const JointVector& q) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double dq = (q[i] - q_[i]) / kT;
      const double ddq = (dq - dq_[i]) / kT;
      acceleration = std::max(acceleration, std::abs(ddq) / limits_.ddq_max[i]);
      jerk = std::max(jerk, std::abs(ddq - ddq_[i]) / kT / limits_.dddq_max[i]);
      q_[i] = q[i];
      dq_[i] = dq;
      ddq_[i] = ddq;
    }
  }

  double acceleration = 0;
  double jerk = 0;

 private:
  JointLimits limits_ = test::PandaLimits();
  JointVector q_;
  JointVector dq_;
  JointVector ddq_{};
};

Target Moving(double t, double speed) {
  Target target;
  target.joint.q.fill(speed * t);
  target.joint.dq.fill(speed);
  return target;
}

/// A source at constant speed behind bridge and reference generator. It stalls after `before` s,
/// for `stall` s, then goes on from where its own time is; `after` s later all is over.
struct Course {
  double speed = 1;
  double before = 1;
  double stall = 0.2;
  double after = 5;

  /// @returns where the reference is at the end.
  double Run(Judge& judge) const {
    StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
    const reference::JointReferenceGenerator generator(1e-3);
    JointVector q_d{};
    Target target = Moving(0, speed);
    bool fresh = true;
    const int cycles = static_cast<int>((before + stall + after) / kT);
    for (int k = 1; k <= cycles; ++k) {
      const double t = k * kT;
      fresh = t <= before || t > before + stall;
      if (fresh) target = Moving(t, speed);
      q_d = generator.Next(q_d, bridge.Next(target, fresh, 1).joint);
      judge.Take(q_d);
    }
    return q_d[0];
  }
};

TEST(StallBridgeTest, PassesAHealthySourceToTheBit) {
  StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
  for (int k = 0; k < 1000; ++k) {
    const Target target = Moving(k * kT, std::sin(k * 0.01));
    const Target out = bridge.Next(target, k % 2 == 0, 1);
    EXPECT_EQ(out.joint.q, target.joint.q);
    EXPECT_EQ(out.joint.dq, target.joint.dq);
  }
  EXPECT_FALSE(bridge.active());
}

TEST(StallBridgeTest, AStallOf200MillisecondsAtOneRadianPerSecondBreaksNoLimit) {
  Judge judge(JointVector{}, JointVector{1, 1, 1, 1, 1, 1, 1});
  const Course course;
  const double end = course.Run(judge);
  EXPECT_LT(judge.acceleration, 1);
  EXPECT_LT(judge.jerk, 1);
  // At the end it has the source again, but for what the generator's time constant of 1 s leaves.
  EXPECT_NEAR(end, 6.2, 0.02);
}

TEST(StallBridgeTest, NeitherDoesOneAtTheTopSpeedOfTheJoints) {
  JointVector top;
  top.fill(2.175);
  Judge judge(JointVector{}, top);
  Course course;
  course.speed = 2.175;
  static_cast<void>(course.Run(judge));
  EXPECT_LT(judge.acceleration, 1);
  EXPECT_LT(judge.jerk, 1);
}

TEST(StallBridgeTest, ADepositAFewCyclesLateDuringAnAccelerationIsNoJump) {
  // Joint 1 accelerates with 3 rad/s^2; after 4 cycles without a deposit the source is 12 mrad/s
  // faster: taken at once that would be 12 rad/s^2 in a cycle, and 12000 rad/s^3.
  const auto at = [](double t) {
    Target target;
    target.joint.q[0] = 1.5 * t * t;
    target.joint.dq[0] = 3 * t;
    return target;
  };
  for (const bool bridged : {true, false}) {
    StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
    const reference::JointReferenceGenerator generator(1e-3);
    JointVector q_d{};
    JointVector dq{};
    dq[0] = 1.5;
    q_d[0] = 1.5 * 0.25;
    Judge judge(q_d, dq);
    Target target = at(0.5);
    for (int k = 501; k <= 700; ++k) {
      const bool fresh = k < 550 || k > 553;
      if (fresh) target = at(k * kT);
      const Target used = bridged ? bridge.Next(target, fresh, 1) : target;
      q_d = generator.Next(q_d, used.joint);
      judge.Take(q_d);
    }
    EXPECT_EQ(judge.jerk < 1, bridged) << judge.jerk;
  }
}

TEST(StallBridgeTest, ASourceThatNeverReturnsDecaysToItsLastTarget) {
  Judge judge(JointVector{}, JointVector{1, 1, 1, 1, 1, 1, 1});
  Course course;
  course.stall = 20;
  course.after = 0;
  const double end = course.Run(judge);
  EXPECT_LT(judge.acceleration, 1);
  EXPECT_NEAR(end, 1.0, 1e-6);
}

TEST(StallBridgeTest, WithoutItTheSameStallIsAStepBeyondEveryLimit) {
  // What the chain would do if the velocity of a stalled source were just taken as zero.
  Judge judge(JointVector{}, JointVector{1, 1, 1, 1, 1, 1, 1});
  const reference::JointReferenceGenerator generator(1e-3);
  JointVector q_d{};
  for (int k = 1; k <= 100; ++k) {
    Target target = Moving(std::min(k, 50) * kT, k <= 50 ? 1 : 0);
    q_d = generator.Next(q_d, target.joint);
    judge.Take(q_d);
  }
  EXPECT_GT(judge.acceleration, 10);
}

TEST(StallBridgeTest, OnceTheOffsetsAreGoneTargetsPassToTheBitAgain) {
  StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
  static_cast<void>(bridge.Next(Moving(0, 0.5), true, 1));
  for (int k = 0; k < 50; ++k) static_cast<void>(bridge.Next(Moving(0, 0.5), false, 1));
  EXPECT_TRUE(bridge.stalled());
  for (int k = 0; k < 10000; ++k) static_cast<void>(bridge.Next(Moving(k * kT, 0.5), true, 1));
  EXPECT_FALSE(bridge.active());
  const Target target = Moving(11, 0.5);
  EXPECT_EQ(bridge.Next(target, true, 1).joint.dq, target.joint.dq);
}

TEST(StallBridgeTest, CyclesThatWereNotAnsweredCountAsWaiting) {
  StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
  static_cast<void>(bridge.Next(Moving(0, 1), true, 1));
  static_cast<void>(bridge.Next(Moving(0, 1), false, kPatience));
  EXPECT_FALSE(bridge.stalled());
  static_cast<void>(bridge.Next(Moving(0, 1), false, 1));
  EXPECT_TRUE(bridge.stalled());
}

TEST(StallBridgeTest, AStalledTorqueSourceDecaysToZeroWithinTheTorqueRate) {
  StallBridge bridge(CommandInterface::kTorque, kPeriod);
  Target target;
  target.tau_J_d.fill(80);
  double last = bridge.Next(target, true, 1).tau_J_d[0];
  for (int k = 0; k < 6000; ++k) {
    const double tau = bridge.Next(target, false, 1).tau_J_d[0];
    EXPECT_LT(std::abs(tau - last) / kT, 1000);
    last = tau;
  }
  EXPECT_NEAR(last, 0, 1e-6);
}

TEST(StallBridgeTest, AStalledVelocitySourceComesToRest) {
  StallBridge bridge(CommandInterface::kJointVelocity, kPeriod);
  static_cast<void>(bridge.Next(Moving(0, 2), true, 1));
  double dq = 2;
  for (int k = 0; k < 6000; ++k) dq = bridge.Next(Moving(0, 2), false, 1).joint.dq[0];
  EXPECT_EQ(dq, 0);
}

TEST(StallBridgeTest, APoseSourceIsCarriedOverAStallWithoutALeap) {
  StallBridge bridge(CommandInterface::kCartesianPose, kPeriod);
  // 0.2 m/s along x and 0.5 rad/s about z.
  const auto pose_at = [](double t) {
    const double a = 0.5 * t;
    Target target;
    target.pose.O_T_EE = {std::cos(a), std::sin(a), 0, 0, -std::sin(a), std::cos(a), 0, 0,
                          0,           0,           1, 0, 0.2 * t,      0,           0, 1};
    target.pose.O_dP_EE = {0.2, 0, 0, 0, 0, 0.5};
    return target;
  };
  Target target = pose_at(0);
  Transform last = bridge.Next(target, true, 1).pose.O_T_EE;
  for (int k = 1; k <= 3000; ++k) {
    const bool fresh = k < 500 || k > 700;
    if (fresh) target = pose_at(k * kT);
    const Transform now = bridge.Next(target, fresh, 1).pose.O_T_EE;
    for (std::size_t i = 0; i < now.size(); ++i) {
      ASSERT_NEAR(now[i], last[i], 2e-3) << "element " << i << " leaps in cycle " << k;
    }
    last = now;
  }
  const Transform end = pose_at(3).pose.O_T_EE;
  for (std::size_t i = 0; i < end.size(); ++i) EXPECT_NEAR(last[i], end[i], 1e-5);
}

TEST(StallBridgeTest, AllocatesNothing) {
  StallBridge bridge(CommandInterface::kJointPosition, kPeriod);
  const test::RealtimeGuard guard;
  for (int k = 0; k < 10000; ++k) {
    static_cast<void>(bridge.Next(Moving(k * kT, 1), k % 300 < 100, 1));
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.locks, 0);
}

}  // namespace
}  // namespace twin::loop
