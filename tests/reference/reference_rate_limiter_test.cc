#include "twin/reference/rate_limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"

namespace twin::reference::reference_rate_limiter_test {
namespace {

constexpr double kT = 1e-3;
constexpr double kTolerance = 1e-9;  // relative; what the robot allows for rounding

/// Largest value over limit of all joints, of velocity, acceleration and jerk.
struct Excess {
  double dq = 0;
  double ddq = 0;
  double dddq = 0;
};

/// The reference as the robot keeps it: backward differences of what is sent, held acceleration on
/// loss.
struct RobotReference {
  JointVector q_d{};
  JointVector dq_d{};
  JointVector ddq_d{};
  JointVector dddq_d{};

  void TakePosition(const JointVector& q_c) {
    JointVector dq;
    for (std::size_t j = 0; j < kJoints; ++j) dq[j] = (q_c[j] - q_d[j]) / kT;
    TakeVelocity(dq);
    q_d = q_c;
  }

  void TakeVelocity(const JointVector& dq_c) {
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double ddq = (dq_c[j] - dq_d[j]) / kT;
      dddq_d[j] = (ddq - ddq_d[j]) / kT;
      ddq_d[j] = ddq;
      dq_d[j] = dq_c[j];
      q_d[j] += kT * dq_c[j];
    }
  }

  void Lose() {
    for (std::size_t j = 0; j < kJoints; ++j) {
      dddq_d[j] = 0;
      dq_d[j] += kT * ddq_d[j];
      q_d[j] += kT * dq_d[j];
    }
  }

  void Record(const JointVector& dq_max, const JointVector& ddq_max, const JointVector& dddq_max,
              Excess& worst) const {
    for (std::size_t j = 0; j < kJoints; ++j) {
      worst.dq = std::max(worst.dq, std::abs(dq_d[j]) / dq_max[j]);
      worst.ddq = std::max(worst.ddq, std::abs(ddq_d[j]) / ddq_max[j]);
      worst.dddq = std::max(worst.dddq, std::abs(dddq_d[j]) / dddq_max[j]);
    }
  }
};

JointVector Limited(const JointVector& q_c, const RobotReference& robot,
                    const ClientLimits& limits) {
  return LimitJointPosition(q_c, robot.q_d, robot.dq_d, robot.ddq_d, limits);
}

/// Commands without manners, in turns: noise in every cycle, steps held for a while, motions far
/// too fast, and silence. Positions stay within 3 rad.
JointVector WildPosition(const Random& random, std::uint64_t k) {
  JointVector q;
  for (std::uint32_t j = 0; j < kJoints; ++j) {
    const double t = static_cast<double>(k) * kT;
    switch (random.Bits(k / 1000, j)[0] % 4) {
      case 0: q[j] = 6 * random.Uniform(k, j) - 3; break;
      case 1: q[j] = 6 * random.Uniform(k / (1 + j * 40), j) - 3; break;
      case 2: q[j] = 3 * std::sin((5 + 40 * random.Uniform(k / 1000, 10 + j)) * t); break;
      default: q[j] = 0.1 * j;
    }
  }
  return q;
}

TEST(RateLimiterTest, LeavesAnAdmissibleMotionAsItIs) {
  // Every joint at 0.9 of its velocity limit and half its acceleration limit or less, from rest.
  const ClientLimits limits = PandaClientLimits();
  RobotReference by_position;
  RobotReference by_velocity;
  for (int k = 1; k <= 20'000; ++k) {
    JointVector q;
    JointVector dq;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double omega = 0.5 * limits.ddq_max[j] / (0.9 * limits.dq_max[j]);
      const double amplitude = 0.9 * limits.dq_max[j] / omega;
      q[j] = amplitude * std::pow(std::sin(omega * k * kT / 2), 2);
      dq[j] = 0.5 * amplitude * omega * std::sin(omega * k * kT);
    }
    const JointVector q_s = Limited(q, by_position, limits);
    const JointVector dq_s =
        LimitJointVelocity(dq, by_velocity.q_d, by_velocity.dq_d, by_velocity.ddq_d, limits);
    for (std::size_t j = 0; j < kJoints; ++j) {
      ASSERT_NEAR(q_s[j], q[j], 1e-12) << "cycle " << k;
      ASSERT_NEAR(dq_s[j], dq[j], 1e-12) << "cycle " << k;
    }
    by_position.TakePosition(q_s);
    by_velocity.TakeVelocity(dq_s);
  }
}

TEST(RateLimiterTest, AStepComesOutWithinTheLimitsInEveryCycle) {
  const ClientLimits limits = PandaClientLimits();
  for (const double step : {1e-6, 1e-3, 0.1, 1.0, -2.0}) {
    RobotReference robot;
    Excess worst;
    for (int k = 0; k < 5000; ++k) {
      robot.TakePosition(Limited(Filled(step), robot, limits));
      robot.Record(limits.dq_max, limits.ddq_max, limits.dddq_max, worst);
    }
    EXPECT_LE(worst.dq, 1 + kTolerance);
    EXPECT_LE(worst.ddq, 1 + kTolerance);
    EXPECT_LE(worst.dddq, 1 + kTolerance);
    EXPECT_GT(worst.dddq, step == 1e-6 ? 0.1 : 0.999);
  }
}

TEST(RateLimiterTest, NoSequenceOfPositionsBreaksVelocityAccelerationOrJerk) {
  const ClientLimits limits = PandaClientLimits();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Random random(seed, RandomStream::kTest);
    RobotReference robot;
    Excess worst;
    for (std::uint64_t k = 0; k < 100'000; ++k) {
      robot.TakePosition(Limited(WildPosition(random, k), robot, limits));
      robot.Record(limits.dq_max, limits.ddq_max, limits.dddq_max, worst);
    }
    EXPECT_LE(worst.dq, 1 + kTolerance) << "seed " << seed;
    EXPECT_LE(worst.ddq, 1 + kTolerance) << "seed " << seed;
    EXPECT_LE(worst.dddq, 1 + kTolerance) << "seed " << seed;
    // All three were put to the test.
    EXPECT_GT(std::min({worst.dq, worst.ddq, worst.dddq}), 0.999) << "seed " << seed;
  }
}

// Joints 5 and 7 of an FR3 are left out: their limit shrinks by up to 17 rad/s^2, and they brake by
// 10, so that nothing can keep it which looks ahead as little as this law.
TEST(RateLimiterTest, TowardsAnEndTheVelocityStaysWithinTheLimitThatShrinksThere) {
  const JointLimits fr3 = test::Fr3Limits();
  const ClientLimits limits = ClientLimits::Of(fr3, test::PandaCartesianLimits());
  for (const bool by_position : {false, true}) {
    for (const double way : {1.0, -1.0}) {
      RobotReference robot;
      for (std::size_t j = 0; j < kJoints; ++j) robot.q_d[j] = (fr3.q_min[j] + fr3.q_max[j]) / 2;
      JointVector largest{};  // share of a limit that has shrunk
      for (int k = 0; k < 5000; ++k) {
        const RobotReference before = robot;
        JointVector dq;
        JointVector q;
        for (std::size_t j = 0; j < kJoints; ++j) {
          dq[j] = way * fr3.dq_max[j];
          q[j] = robot.q_d[j] + dq[j] * kT;
        }
        if (by_position) {
          robot.TakePosition(Limited(q, robot, limits));
        } else {
          robot.TakeVelocity(LimitJointVelocity(dq, robot.q_d, robot.dq_d, robot.ddq_d, limits));
        }
        for (const std::size_t j : {0, 1, 2, 3, 5}) {
          const double limit = fr3.VelocityLimit(j, before.q_d[j], way);
          ASSERT_LE(way * robot.dq_d[j], limit + kTolerance)
              << "joint " << j + 1 << ", cycle " << k;
          if (limit > 0.1 && limit < 0.9 * fr3.dq_max[j]) {
            largest[j] = std::max(largest[j], way * robot.dq_d[j] / limit);
          }
        }
      }
      for (const std::size_t j : {0, 1, 2, 3, 5}) {
        EXPECT_GT(largest[j], 0.95) << "joint " << j + 1;
        EXPECT_NEAR(robot.dq_d[j], 0, 1e-6) << "joint " << j + 1;
        EXPECT_LT(std::abs((way > 0 ? fr3.q_max : fr3.q_min)[j] - robot.q_d[j]), 0.02);
      }
    }
  }
}

TEST(RateLimiterTest, NoSequenceOfVelocitiesBreaksVelocityAccelerationOrJerk) {
  const ClientLimits limits = PandaClientLimits();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Random random(seed, RandomStream::kTest);
    RobotReference robot;
    Excess worst;
    for (std::uint64_t k = 0; k < 100'000; ++k) {
      robot.TakeVelocity(
          LimitJointVelocity(WildPosition(random, k), robot.q_d, robot.dq_d, robot.ddq_d, limits));
      robot.Record(limits.dq_max, limits.ddq_max, limits.dddq_max, worst);
    }
    EXPECT_LE(worst.dq, 1 + kTolerance) << "seed " << seed;
    EXPECT_LE(worst.ddq, 1 + kTolerance) << "seed " << seed;
    EXPECT_LE(worst.dddq, 1 + kTolerance) << "seed " << seed;
    EXPECT_GT(std::min({worst.dq, worst.ddq, worst.dddq}), 0.999) << "seed " << seed;
  }
}

/// Wild positions with runs of at most `longest` lost commands; every second cycle begins one.
/// @param resumed  [n]: worst of the commands that come after n lost ones, jerk over its limit.
Excess UnderLoss(std::uint64_t longest, std::array<double, 4>& resumed) {
  const ClientLimits limits = PandaClientLimits();
  const JointLimits robot_limits = test::PandaLimits();
  const Random random(longest, RandomStream::kTest);
  RobotReference robot;
  Excess worst;
  std::uint64_t lost = 0;
  std::uint64_t to_lose = 0;
  for (std::uint64_t k = 0; k < 300'000; ++k) {
    if (to_lose > 0) {
      robot.Lose();
      --to_lose;
      ++lost;
    } else {
      // Held for a while, so that the velocity limit is met at full acceleration.
      robot.TakePosition(Limited(WildPosition(random, k), robot, limits));
      Excess now;
      robot.Record(limits.dq_max, limits.ddq_max, limits.dddq_max, now);
      resumed[lost] = std::max(resumed[lost], now.dddq);
      lost = 0;
      to_lose = random.Bits(k, 50)[0] % 2 * (1 + random.Bits(k, 51)[0] % longest);
    }
    robot.Record(robot_limits.dq_max, limits.ddq_max, limits.dddq_max, worst);
  }
  return worst;
}

TEST(RateLimiterTest, VelocityAndAccelerationHoldOverThreeLostCommands) {
  for (std::uint64_t longest = 1; longest <= 3; ++longest) {
    std::array<double, 4> resumed{};
    const Excess worst = UnderLoss(longest, resumed);
    EXPECT_LE(worst.dq, 1) << "of the robot's own limit, longest run " << longest;
    // Where the velocity is beyond -V, the law's lower bound is not held by A: 4 J T/A - 1.
    const double most = longest < 3 ? 1 : 4 * 3749.999 * kT / 7.499 - 1;
    EXPECT_LE(worst.ddq, most + kTolerance) << "longest run " << longest;
  }
}

TEST(RateLimiterTest, JerkAfterLostCommandsIsOverItsLimitButBounded) {
  std::array<double, 4> resumed{};
  (void)UnderLoss(3, resumed);
  for (std::size_t n = 1; n <= 3; ++n) {
    EXPECT_LE(resumed[n], static_cast<double>(n + 1) + 1e-6) << n << " lost";
    // The bound is reached: the header's denial of a jerk limit is not empty.
    EXPECT_GT(resumed[n], static_cast<double>(n) + 0.9) << n << " lost";
  }
}

TEST(RateLimiterTest, DoesNotBoundThePosition) {
  const ClientLimits limits = PandaClientLimits();
  const JointLimits robot_limits = test::PandaLimits();
  RobotReference robot;
  JointVector farthest{};
  for (int k = 0; k < 5000; ++k) {
    robot.TakePosition(Limited(robot_limits.q_max, robot, limits));
    for (std::size_t j = 0; j < kJoints; ++j) farthest[j] = std::max(farthest[j], robot.q_d[j]);
  }
  // A command at the very limit is overshot.
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (robot_limits.q_max[j] > 0.1) {
      EXPECT_GT(farthest[j], robot_limits.q_max[j] + 0.01) << "joint " << j + 1;
    }
  }
}

TEST(RateLimiterTest, ATorqueChangesNoFasterThanItsLimit) {
  const ClientLimits limits = PandaClientLimits();
  const Random random(7, RandomStream::kTest);
  JointVector tau_J_d{};
  double fastest = 0;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    JointVector wished;
    for (std::uint32_t j = 0; j < kJoints; ++j) {
      wished[j] = 87 * (2 * random.Uniform(k / (1 + 30 * j), j) - 1);
    }
    const JointVector next = LimitTorque(wished, tau_J_d, limits);
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double rate = std::abs(next[j] - tau_J_d[j]) / kT;
      ASSERT_LE(rate, limits.dtau_max[j] * (1 + kTolerance));
      fastest = std::max(fastest, rate);
      // A smaller change passes; a larger one goes the same way.
      if (std::abs(wished[j] - tau_J_d[j]) <= limits.dtau_max[j] * kT) {
        ASSERT_NEAR(next[j], wished[j], 1e-13);
      } else {
        ASSERT_NEAR(rate, limits.dtau_max[j], 1e-6);
        ASSERT_EQ(next[j] > tau_J_d[j], wished[j] > tau_J_d[j]);
      }
    }
    tau_J_d = next;
  }
  EXPECT_GT(fastest, 999);
}

TEST(RateLimiterTest, HandsOnWhatIsNotFinite) {
  const ClientLimits limits = PandaClientLimits();
  const double infinity = std::numeric_limits<double>::infinity();
  const JointVector bad{std::nan(""), infinity, -infinity, 5, 0, 0, 0};
  for (const JointVector& out :
       {LimitJointPosition(bad, {}, {}, {}, limits), LimitJointVelocity(bad, {}, {}, {}, limits),
        LimitTorque(bad, {}, limits)}) {
    EXPECT_TRUE(std::isnan(out[0]));
    EXPECT_EQ(out[1], infinity);
    EXPECT_EQ(out[2], -infinity);
    EXPECT_TRUE(std::isfinite(out[3]) && out[3] > 0 && out[3] < 5) << out[3];
  }
}

TEST(RateLimiterTest, AllocatesNothing) {
  const ClientLimits limits = PandaClientLimits();
  const Random random(8, RandomStream::kTest);
  RobotReference robot;
  JointVector tau{};
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    const JointVector wild = WildPosition(random, k);
    robot.TakePosition(Limited(wild, robot, limits));
    robot.TakeVelocity(LimitJointVelocity(wild, robot.q_d, robot.dq_d, robot.ddq_d, limits));
    tau = LimitTorque(wild, tau, limits);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(tau[0], 0);
}

}  // namespace
}  // namespace twin::reference::reference_rate_limiter_test
