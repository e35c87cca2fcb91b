#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <Eigen/Geometry>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/reference/rate_limiter.h"

namespace twin::reference::reference_cartesian_rate_limiter_test {
namespace {

using Eigen::Vector3d;

constexpr double kT = 1e-3;
constexpr double kTolerance = 1e-9;  // relative; what the robot allows for rounding

/// Velocity, acceleration and jerk of three axes, as the robot keeps them.
struct Motion {
  Vector3d v = Vector3d::Zero();
  Vector3d a = Vector3d::Zero();
  Vector3d j = Vector3d::Zero();

  void Take(const Vector3d& v_next) {
    const Vector3d a_next = (v_next - v) / kT;
    j = (a_next - a) / kT;
    a = a_next;
    v = v_next;
  }
};

/// The commanded pose as the robot keeps it.
struct RobotPose {
  Transform O_T_EE_c = kIdentityTransform;
  Motion translation;
  Motion rotation;

  void TakePose(const Transform& next) {
    translation.Take((PositionOf(next) - PositionOf(O_T_EE_c)) / kT);
    rotation.Take(RotationVector(O_T_EE_c, next) / kT);
    O_T_EE_c = next;
  }
  void TakeTwist(const Vector6& twist) {
    translation.Take(Vector3d(twist[0], twist[1], twist[2]));
    rotation.Take(Vector3d(twist[3], twist[4], twist[5]));
  }
  [[nodiscard]] Vector6 twist() const { return Joined(translation.v, rotation.v); }
  [[nodiscard]] Vector6 acceleration() const { return Joined(translation.a, rotation.a); }

  static Vector6 Joined(const Vector3d& a, const Vector3d& b) {
    return {a[0], a[1], a[2], b[0], b[1], b[2]};
  }
};

Transform Limited(const Transform& wish, const RobotPose& robot, const ClientLimits& limits) {
  return LimitCartesianPose(wish, robot.O_T_EE_c, robot.twist(), robot.acceleration(), limits);
}

Vector6 Limited(const Vector6& wish, const RobotPose& robot, const ClientLimits& limits) {
  return LimitCartesianVelocity(wish, robot.twist(), robot.acceleration(), limits);
}

/// Largest value over limit; the jerk also apart for cycles that began with the speed at least
/// A^2/J below its limit.
struct Excess {
  double v = 0;
  double a = 0;
  double j = 0;
  double j_below = 0;

  void Record(const Motion& motion, const Vector3d& v_before, const CartesianBound& bound) {
    v = std::max(v, motion.v.norm() / bound.dp_max);
    a = std::max(a, motion.a.norm() / bound.ddp_max);
    const double jerk = motion.j.norm() / bound.dddp_max;
    j = std::max(j, jerk);
    const double room = bound.dp_max - v_before.norm();
    if (room >= bound.ddp_max * bound.ddp_max / bound.dddp_max) j_below = std::max(j_below, jerk);
  }

  void ExpectGuaranteed(const CartesianBound& bound) const {
    EXPECT_LE(v, 1 + kTolerance);
    EXPECT_LE(a, 1 + kTolerance);
    EXPECT_LE(j_below, 1 + kTolerance);
    EXPECT_LE(j, bound.ddp_max / kT / bound.dddp_max * (1 + kTolerance));
    EXPECT_GT(std::min({v, a, j_below}), 0.999) << "all were put to the test";
  }
};

CartesianBound PoseRotationBound(const ClientLimits& limits) {
  return {0.99 * limits.rotation.dp_max, 0.99 * limits.rotation.ddp_max,
          0.99 * limits.rotation.dddp_max};
}

/// Commands without manners, in turns: noise in every cycle, poses held for a while, silence.
Transform WildPose(const Random& random, std::uint64_t k) {
  switch (random.Bits(k / 1000)[0] % 3) {
    case 0: return RandomPose(random, k);
    case 1: return RandomPose(random, k / 100);
    default: return kIdentityTransform;
  }
}

/// A motion well inside all limits: screws about changing axes.
Transform AdmissiblePose(double t) {
  const double s = std::pow(std::sin(t / 2), 2);
  return PoseOf({0.9 * s, -0.6 * s * s, 0.4 * std::sin(t) * s}, {0.5 * s, 0.3 * s * s, -0.4 * s});
}

TEST(CartesianRateLimiterTest, LeavesAnAdmissibleMotionAsItIs) {
  const ClientLimits limits = PandaClientLimits();
  RobotPose by_pose;
  RobotPose by_twist;
  for (int k = 1; k <= 20'000; ++k) {
    const Transform X = AdmissiblePose(k * kT);
    const Transform X_s = Limited(X, by_pose, limits);
    for (std::size_t i = 0; i < X.size(); ++i) ASSERT_NEAR(X_s[i], X[i], 1e-12) << "cycle " << k;
    by_pose.TakePose(X_s);
    const Vector6 twist = by_pose.twist();
    const Vector6 twist_s = Limited(twist, by_twist, limits);
    for (std::size_t i = 0; i < 6; ++i) ASSERT_NEAR(twist_s[i], twist[i], 1e-12) << "cycle " << k;
    by_twist.TakeTwist(twist_s);
  }
}

TEST(CartesianRateLimiterTest, AStepComesOutWithinTheLimitsInEveryCycle) {
  const ClientLimits limits = PandaClientLimits();
  const Transform step = PoseOf({0.5, -0.3, 0.2}, {0.2, 0.3, -0.1});
  RobotPose robot;
  Excess translation;
  Excess rotation;
  for (int k = 0; k < 5000; ++k) {
    const RobotPose before = robot;
    const Transform X = Limited(step, robot, limits);
    robot.TakePose(X);
    translation.Record(robot.translation, before.translation.v, limits.translation);
    rotation.Record(robot.rotation, before.rotation.v, PoseRotationBound(limits));
    ASSERT_LT(Obliqueness(X), 1e-14);
  }
  // Along one line the three-axis law is that of one axis: the jerk keeps its limit, too.
  for (const Excess& worst : {translation, rotation}) {
    EXPECT_LE(std::max({worst.v, worst.a, worst.j}), 1 + kTolerance);
    EXPECT_GT(worst.j, 0.999);
  }
}

TEST(CartesianRateLimiterTest, NoSequenceOfPosesBreaksSpeedOrAcceleration) {
  const ClientLimits limits = PandaClientLimits();
  const Random random(1, RandomStream::kTest);
  RobotPose robot;
  Excess translation;
  Excess rotation;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    const RobotPose before = robot;
    robot.TakePose(Limited(WildPose(random, k), robot, limits));
    translation.Record(robot.translation, before.translation.v, limits.translation);
    rotation.Record(robot.rotation, before.rotation.v, PoseRotationBound(limits));
  }
  translation.ExpectGuaranteed(limits.translation);
  rotation.ExpectGuaranteed(PoseRotationBound(limits));
}

TEST(CartesianRateLimiterTest, NoSequenceOfTwistsBreaksSpeedOrAcceleration) {
  const ClientLimits limits = PandaClientLimits();
  const Random random(2, RandomStream::kTest);
  RobotPose robot;
  Excess translation;
  Excess rotation;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    const RobotPose before = robot;
    const std::uint64_t held = k / 2000 % 2 == 0 ? k : k / 150;
    const Vector6 wish =
        RobotPose::Joined(4 * RandomVector(random, held, 0), 6 * RandomVector(random, held, 3));
    robot.TakeTwist(Limited(wish, robot, limits));
    translation.Record(robot.translation, before.translation.v, limits.translation);
    rotation.Record(robot.rotation, before.rotation.v, limits.rotation);
  }
  translation.ExpectGuaranteed(limits.translation);
  rotation.ExpectGuaranteed(limits.rotation);
}

TEST(CartesianRateLimiterTest, TurningAtTheSpeedLimitBreaksTheJerkLimit) {
  // At full speed along x with the largest acceleration along y, pushed along x as well: the speed
  // limit takes the whole acceleration away at once.
  const ClientLimits limits = PandaClientLimits();
  const CartesianBound& bound = limits.translation;
  const double inside = bound.dp_max * (1 - 1e-9);
  RobotPose robot;
  robot.translation.v = {inside, 0, 0};
  robot.translation.a = {0, bound.ddp_max, 0};
  const Vector6 twist = Limited(Vector6{9, 9, 0, 0, 0, 0}, robot, limits);
  const Vector3d a((twist[0] - inside) / kT, twist[1] / kT, twist[2] / kT);
  const double jerk = (a - Vector3d(0, bound.ddp_max, 0)).norm() / kT;
  EXPECT_GT(jerk, 1.9 * bound.dddp_max);
  EXPECT_LE(jerk, bound.ddp_max / kT * (1 + kTolerance));
}

TEST(CartesianRateLimiterTest, AlongOneAxisIsTheLawOfOneAxis) {
  ClientLimits limits = PandaClientLimits();
  limits.elbow = limits.translation;
  const Random random(3, RandomStream::kTest);
  RobotPose robot;
  double elbow = 0;
  for (std::uint64_t k = 0; k < 20'000; ++k) {
    const double wish = 2 * random.Uniform(k / (1 + k / 100 % 200)) - 1;
    const Elbow one = LimitElbow({wish, -1}, {elbow, -1}, {robot.translation.v[1], 0},
                                 {robot.translation.a[1], 0}, limits);
    const Transform three = Limited(PoseOf({0, 0, 0}, {0, wish, 0}), robot, limits);
    ASSERT_NEAR(three[13], one[0], 1e-15) << "cycle " << k;
    ASSERT_EQ(one[1], -1);
    robot.TakePose(three);
    elbow = three[13];
  }
}

TEST(CartesianRateLimiterTest, APoseMayUseNinetyNinePercentOfTheRotationsLimits) {
  const ClientLimits limits = PandaClientLimits();
  RobotPose by_pose;
  RobotPose by_twist;
  for (int k = 0; k < 400; ++k) {
    Transform ahead = by_pose.O_T_EE_c;
    Eigen::Map<Eigen::Matrix4d>(ahead.data()).topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(1, Vector3d::UnitZ()) * RotationOf(by_pose.O_T_EE_c);
    by_pose.TakePose(Limited(ahead, by_pose, limits));
    by_twist.TakeTwist(Limited(Vector6{0, 0, 0, 0, 0, 9}, by_twist, limits));
    if (k != 0) continue;
    EXPECT_NEAR(by_pose.rotation.j[2], 0.99 * limits.rotation.dddp_max, 1e-3);
    EXPECT_NEAR(by_twist.rotation.j[2], limits.rotation.dddp_max, 1e-3);
  }
  EXPECT_NEAR(by_pose.rotation.v[2], 0.99 * limits.rotation.dp_max, 1e-6);
  EXPECT_NEAR(by_twist.rotation.v[2], limits.rotation.dp_max, 1e-6);
}

TEST(CartesianRateLimiterTest, BrakesFromBeyondTheSpeedLimitWithinTheAcceleration) {
  // Where held accelerations may have brought it; whatever is wished for.
  const ClientLimits limits = PandaClientLimits();
  const CartesianBound& bound = limits.translation;
  const Random random(4, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 200; ++k) {
    RobotPose robot;
    robot.translation.v = 1.2 * bound.dp_max * RandomVector(random, k, 0).normalized();
    robot.translation.a = bound.ddp_max * RandomVector(random, k, 3).normalized();
    for (std::uint64_t cycle = 0; cycle < 1000; ++cycle) {
      robot.TakeTwist(Limited(Vector6{}, robot, limits));
      ASSERT_TRUE(robot.translation.v.allFinite());
      ASSERT_LE(robot.translation.a.norm(), bound.ddp_max * (1 + kTolerance));
    }
    EXPECT_LT(robot.translation.v.norm(), bound.dp_max);
  }
}

TEST(CartesianRateLimiterTest, HandsOnWhatIsNotFinite) {
  const ClientLimits limits = PandaClientLimits();
  const RobotPose robot;
  Transform X = kIdentityTransform;
  X[13] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Limited(X, robot, limits), X);
  X[13] = std::nan("");
  EXPECT_TRUE(std::isnan(Limited(X, robot, limits)[13]));
  EXPECT_TRUE(std::isnan(Limited(Vector6{0, std::nan(""), 0, 0, 0, 0}, robot, limits)[1]));
  EXPECT_TRUE(std::isnan(LimitElbow({std::nan(""), 1}, {}, {}, {}, limits)[0]));
}

TEST(CartesianRateLimiterTest, AllocatesNothing) {
  const ClientLimits limits = PandaClientLimits();
  const Random random(5, RandomStream::kTest);
  RobotPose robot;
  Elbow elbow{0, 1};
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    robot.TakePose(Limited(WildPose(random, k), robot, limits));
    robot.TakeTwist(Limited(Vector6{1, 0, 0, 0, 1, 0}, robot, limits));
    elbow = LimitElbow({random.Uniform(k), 1}, elbow, {}, {}, limits);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(elbow[0], 0);
}

}  // namespace
}  // namespace twin::reference::reference_cartesian_rate_limiter_test
