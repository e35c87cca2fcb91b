#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "teleop/teleop_fixture.h"
#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"
#include "twin/teleop/shaped_pose.h"
#include "twin/teleop/shaped_velocity.h"

namespace twin::teleop::teleop_shaping_test {
namespace {

using Eigen::Vector3d;

constexpr double kT = kCycleSeconds;
constexpr MotionBounds kBounds{.speed = 0.25, .acceleration = 2, .jerk = 60};

/// The wildest an operator can be: full deflections to all sides, held for random times.
class WildWish {
 public:
  Vector3d Next() {
    if (left_-- > 0) return wish_;
    const Random random(7, RandomStream::kTest);
    ++draw_;
    left_ = static_cast<int>(400 * random.Uniform(draw_, 0));
    for (std::uint32_t i = 0; i < 3; ++i) wish_[i] = 10 * random.Normal(draw_, i + 1);
    return wish_;
  }

 private:
  Vector3d wish_ = Vector3d::Zero();
  int left_ = 0;
  std::uint64_t draw_ = 0;
};

struct Worst {
  double speed = 0;
  double acceleration = 0;
  double jerk = 0;
};

/// By differences of what comes out.
Worst WorstOf(int steps, double T) {
  ShapedVelocity<3> shaped(kBounds);
  WildWish wish;
  Worst worst;
  Vector3d v = Vector3d::Zero();
  Vector3d a = Vector3d::Zero();
  for (int i = 0; i < steps; ++i) {
    const Vector3d v_now = shaped.Next(wish.Next(), T);
    const Vector3d a_now = (v_now - v) / T;
    worst.speed = std::max(worst.speed, v_now.norm());
    worst.acceleration = std::max(worst.acceleration, a_now.norm());
    worst.jerk = std::max(worst.jerk, (a_now - a).norm() / T);
    v = v_now;
    a = a_now;
  }
  return worst;
}

TEST(ShapedVelocityTest, KeepsTheAccelerationUnderAWildWish) {
  EXPECT_LE(WorstOf(60'000, kT).acceleration, kBounds.acceleration * (1 + 1e-9));
}

TEST(ShapedVelocityTest, KeepsTheJerkUnderAWildWish) {
  EXPECT_LE(WorstOf(60'000, kT).jerk, kBounds.jerk * (1 + 1e-6));
}

TEST(ShapedVelocityTest, KeepsTheSpeedWithinTwoPercentUnderAWildWish) {
  EXPECT_LE(WorstOf(60'000, kT).speed, kBounds.speed * 1.02);
}

TEST(ShapedVelocityTest, KeepsItsBoundsAtAHundredHertz) {
  const Worst worst = WorstOf(20'000, 0.01);
  EXPECT_LE(worst.speed, kBounds.speed * 1.02);
  EXPECT_LE(worst.acceleration, kBounds.acceleration * (1 + 1e-9));
}

TEST(ShapedVelocityTest, ComesToExactRest) {
  ShapedVelocity<3> shaped(kBounds);
  for (int i = 0; i < 500; ++i) shaped.Next({0.2, 0, 0}, kT);
  for (int i = 0; i < 4000; ++i) shaped.Next(Vector3d::Zero(), kT);
  EXPECT_TRUE(shaped.rests());
}

TEST(ShapedVelocityTest, ReachesWhatIsWished) {
  ShapedVelocity<1> shaped(kBounds);
  Eigen::Matrix<double, 1, 1> wish;
  wish << 0.2;
  for (int i = 0; i < 2000; ++i) shaped.Next(wish, kT);
  EXPECT_NEAR(shaped.v()[0], 0.2, 1e-6);
}

/// A pose that is led for some time, the end effector with it.
struct Led {
  ShapedPose pose{TeleoperatorConfig().along, TeleoperatorConfig().about,
                  TeleoperatorConfig().workspace};
  Transform X = [] {
    Transform begin = kIdentityTransform;
    begin[12] = 0.5;
    begin[14] = 0.4;
    return begin;
  }();

  Led() { pose.Begin(X); }
  void Run(const Vector6& twist, int steps) {
    for (int i = 0; i < steps; ++i) X = pose.Next(twist, X, kT).O_T_EE;
  }
};

TEST(ShapedPoseTest, StopsBeforeTheSideOfItsBox) {
  Led led;
  led.Run({0, 0, -10, 0, 0, 0}, 12'000);
  const double low = TeleoperatorConfig().workspace.low[2];
  EXPECT_GE(led.X[14], low - 1e-4);
  EXPECT_LE(led.X[14], low + 0.3);
}

TEST(ShapedPoseTest, TellsThatItIsAtABorder) {
  Led led;
  led.Run({0, 0.2, 0, 0, 0, 0}, 12'000);
  EXPECT_TRUE(led.pose.at_border());
}

TEST(ShapedPoseTest, NeverLeavesItsShellUnderAWildWish) {
  Led led;
  WildWish wish;
  const Workspace workspace = TeleoperatorConfig().workspace;
  double farthest = 0;
  double nearest = 1;
  for (int i = 0; i < 120'000; ++i) {
    const Vector3d u = wish.Next();
    led.Run({u[0], u[1], u[2], 0, 0, 0}, 1);
    const double distance = std::hypot(led.X[12], led.X[13], led.X[14] - 0.333);
    farthest = std::max(farthest, distance);
    nearest = std::min(nearest, distance);
  }
  EXPECT_LE(farthest, workspace.farthest + 5e-3);
  EXPECT_GE(nearest, workspace.nearest - 5e-3);
}

TEST(ShapedPoseTest, GoesNoFurtherAheadOfAnArmThatIsStoppedThanItMayPress) {
  Led led;
  const Transform wall = led.X;
  for (int i = 0; i < 5000; ++i) led.pose.Next({0.25, 0, 0, 0, 0, 0}, wall, kT);
  const double ahead = led.pose.target().O_T_EE[12] - wall[12];
  EXPECT_NEAR(ahead, TeleoperatorConfig().workspace.press, 1e-3);
}

TEST(ShapedPoseTest, ReachesAWishedPoseAtRest) {
  Led led;
  Transform wish = led.X;
  wish[12] += 0.05;
  wish[13] -= 0.1;
  const Transform turned = model::Turned(wish, Vector3d(0, 0, 0.7), model::Position(wish));
  for (int i = 0; i < 6000; ++i) led.Run(led.pose.TwistTowards(turned, kT), 1);
  EXPECT_LT((model::Position(led.X) - model::Position(turned)).norm(), 1e-6);
  EXPECT_LT(model::TurnBetween(led.X, turned).norm(), 1e-6);
  EXPECT_LT(HalfNorm(led.pose.target().O_dP_EE, 0), 1e-6);
}

TEST(ShapedPoseTest, DoesNotGoBeyondAWishedPose) {
  Led led;
  Transform wish = led.X;
  wish[13] += 0.2;
  double most = 0;
  for (int i = 0; i < 6000; ++i) {
    led.Run(led.pose.TwistTowards(wish, kT), 1);
    most = std::max(most, led.X[13]);
  }
  EXPECT_LE(most, wish[13] + 2e-4);
}

TEST(PostureGuardTest, LetsAFreeArmGo) {
  const PostureGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits());
  RobotState state;
  state.q = test::kReady;
  EXPECT_EQ(guard.Share(state, {0.1, 0.1, -0.1, 0.2, 0, 0}), 1);
}

/// Nearly stretched out, and the way from the shoulder to the wrist at 0.2 m/s.
struct Stretched {
  RobotState state;
  Vector6 outwards{};

  Stretched() {
    state.q = {0, 0.3, 0, -0.65, 0, 1.57, 0.785};
    const Transform wrist = model::ArmModel::Panda().Pose(model::Frame::kJoint6, state.q);
    const double length = std::hypot(wrist[12], wrist[13], wrist[14] - 0.333);
    for (std::size_t i = 0; i < 3; ++i) {
      outwards[i] = 0.2 * (wrist[12 + i] - (i == 2 ? 0.333 : 0)) / length;
    }
  }
};

TEST(PostureGuardTest, HoldsAnArmThatIsAboutToBeStretchedOut) {
  const PostureGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits());
  const Stretched arm;
  EXPECT_EQ(guard.Share(arm.state, arm.outwards), 0);
}

TEST(PostureGuardTest, LetsAStretchedArmComeBack) {
  const PostureGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits());
  const Stretched arm;
  Vector6 back = arm.outwards;
  for (double& u : back) u = -u;
  EXPECT_EQ(guard.Share(arm.state, back), 1);
}

TEST(PostureGuardTest, HoldsAJointAtTheEndOfItsRange) {
  const PostureGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits());
  RobotState state;
  state.q = test::kReady;
  state.q[6] = 2.8;  // of 2.8973; the flange points down: turning left about z up takes it back
  EXPECT_LT(
      std::min(guard.Share(state, {0, 0, 0, 0, 0, 0.5}), guard.Share(state, {0, 0, 0, 0, 0, -0.5})),
      0.5);
  EXPECT_EQ(
      std::max(guard.Share(state, {0, 0, 0, 0, 0, 0.5}), guard.Share(state, {0, 0, 0, 0, 0, -0.5})),
      1);
}

}  // namespace
}  // namespace twin::teleop::teleop_shaping_test
