#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/QR>

#include "teleop/teleop_fixture.h"
#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"
#include "twin/teleop/motion_guard.h"
#include "twin/teleop/shaped_pose.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/twist_bounds.h"

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
  TwistBounds bounds{TeleoperatorConfig().along.speed, TeleoperatorConfig().about.speed};
  ActiveBound active{};
  Transform X = [] {
    Transform begin = kIdentityTransform;
    begin[12] = 0.5;
    begin[14] = 0.4;
    return begin;
  }();

  Led() { pose.Begin(X); }
  /// Leads the pose while the end effector stays at `measured`.
  const Transform& Step(const Vector6& twist, const Transform& measured) {
    bounds.Clear();
    pose.AddTo(bounds, model::WayTo(measured, pose.target().O_T_EE), kT);
    const AllowedTwist allowed = bounds.Closest(twist);
    active = allowed.strongest;
    return pose.Next(allowed.u, kT).O_T_EE;
  }
  void Run(const Vector6& twist, int steps) {
    for (int i = 0; i < steps; ++i) X = Step(twist, X);
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
  EXPECT_EQ(led.active.bound, Bound::kWorkspace);
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
  for (int i = 0; i < 5000; ++i) led.Step({0.25, 0, 0, 0, 0, 0}, wall);
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

/// What a guard leaves of a twist at a configuration.
struct Guarded {
  Vector6 allowed{};
  ActiveBound active;

  /// @param q_r  of the reference; the arm is at q.
  Guarded(const JointVector& q, const Vector6& twist, const JointVector& q_r,
          Surroundings* surroundings = nullptr) {
    MotionGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits(), true, surroundings);
    TwistBounds bounds(TeleoperatorConfig().along.speed, TeleoperatorConfig().about.speed);
    RobotState state;
    state.q = q;
    guard.AddTo(bounds, {.q = q_r}, {}, state);
    const AllowedTwist closest = bounds.Closest(twist);
    allowed = closest.u;
    active = closest.strongest;
  }
  Guarded(const JointVector& q, const Vector6& twist) : Guarded(q, twist, q) {}
};

double Along(const Vector6& a, const Vector6& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

TEST(TwistBoundsTest, LeavesTheMotionAlongABound) {
  TwistBounds bounds(1, 1);
  bounds.Add({1, 1, 0, 0, 0, 0}, 0, {Bound::kWorkspace});
  const auto [allowed, active, meets_all] = bounds.Closest({1, 0, 0.5, 0, 0, 0.2});
  const Vector6 projected{0.5, -0.5, 0.5, 0, 0, 0.2};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(allowed[i], projected[i], 1e-12);
  EXPECT_EQ(active.bound, Bound::kWorkspace);
}

TEST(TwistBoundsTest, SatisfiesEveryBoundOfManyAndKeepsWhatTheyAllow) {
  const Random random(11, RandomStream::kTest);
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    std::uint32_t draw = 0;
    const auto vector = [&] {
      Vector6 v;
      for (double& x : v) x = random.Normal(trial, draw++);
      return v;
    };
    TwistBounds bounds(0.25, 0.8);
    std::vector<std::pair<Vector6, double>> rows;
    for (int k = 0; k < 12; ++k) {
      rows.emplace_back(vector(), std::abs(random.Normal(trial, draw++)));
      bounds.Add(rows.back().first, rows.back().second, {Bound::kScene});
    }
    const Vector6 wild = vector();
    const auto part = [&](std::size_t i, double most) {
      return most * wild[i] / (1 + std::abs(wild[i])) / std::sqrt(3);
    };
    const Vector6 u{part(0, 0.25), part(1, 0.25), part(2, 0.25),
                    part(3, 0.8),  part(4, 0.8),  part(5, 0.8)};
    const auto [allowed, active, meets_all] = bounds.Closest(u);
    double excess = 0;
    for (const auto& [a, b] : rows) {
      EXPECT_LE(Along(a, allowed), b + 1.1e-4);
      excess = std::max(excess, Along(a, u) - b);
    }
    for (std::size_t i = 0; i < 6 && excess <= 0; ++i) EXPECT_NEAR(allowed[i], u[i], 1e-12);
  }
}

TEST(TwistBoundsTest, MeetsABoundWithinTheSpeedItHas) {
  TwistBounds bounds(1, 1);
  bounds.Add({-0.6, -0.8, 0, 0, 0, 0}, -0.8, {Bound::kJointEnd});
  const auto [allowed, active, meets_all] = bounds.Closest({1, 0, 0, 0, 0, 0});
  EXPECT_TRUE(meets_all);
  // The point of the unit circle at which 0.6 x + 0.8 y = 0.8 next to (1, 0).
  const Vector6 expected{0.96, 0.28, 0, 0, 0, 0};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(allowed[i], expected[i], 1e-4) << i;
}

TEST(TwistBoundsTest, PassesNoneOfTheBoundsThatCannotAllBeMet) {
  TwistBounds bounds(1, 1);
  bounds.Add({1, 0, 0, 0, 0, 0}, -0.1, {Bound::kJointEnd, 5});
  bounds.Add({-1, 0.2, 0, 0, 0, 0}, -0.2, {Bound::kSelf});
  const auto [allowed, active, meets_all] = bounds.Closest({1, 0.1, 1, 0, 0, 0});
  EXPECT_FALSE(meets_all);
  EXPECT_LE(allowed[0], 1.1e-4);
  EXPECT_LE(0.2 * allowed[1] - allowed[0], 1.1e-4);
  EXPECT_GT(allowed[2], 0.3) << "what neither forbids goes on";
}

TEST(MotionGuardTest, LetsAFreeArmGo) {
  const Vector6 twist{0.1, 0.1, -0.1, 0.2, 0, 0};
  const Guarded guarded(test::kReady, twist);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(guarded.allowed[i], twist[i], 1e-12);
  EXPECT_EQ(guarded.active.bound, Bound::kNone);
}

/// Nearly stretched out, and the way from the shoulder to the wrist at 0.2 m/s.
struct Stretched {
  JointVector q{0, 0.3, 0, -0.65, 0, 1.57, 0.785};
  Vector6 outwards{};

  Stretched() {
    const Transform wrist = model::ArmModel::Panda().Pose(model::Frame::kJoint6, q);
    const double length = std::hypot(wrist[12], wrist[13], wrist[14] - 0.333);
    for (std::size_t i = 0; i < 3; ++i) {
      outwards[i] = 0.2 * (wrist[12 + i] - (i == 2 ? 0.333 : 0)) / length;
    }
  }
};

TEST(MotionGuardTest, HoldsAnArmThatIsAboutToBeStretchedOut) {
  const Stretched arm;
  const Guarded guarded(arm.q, arm.outwards);
  EXPECT_LE(Along(guarded.allowed, arm.outwards), 0.05 * Along(arm.outwards, arm.outwards));
  EXPECT_EQ(guarded.active.bound, Bound::kSingular);
}

TEST(MotionGuardTest, LetsAStretchedArmComeBack) {
  const Stretched arm;
  // Slowly: joint 4 turns at 6 rad/s for the whole 0.2 m/s.
  Vector6 back = arm.outwards;
  for (double& u : back) u *= -0.1;
  const Vector6 allowed = Guarded(arm.q, back).allowed;
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(allowed[i], back[i], 1e-12);
}

/// Joint 7 at 2.83 of 2.8973 rad; the flange points down: a positive turn about z takes it back.
constexpr JointVector kAtTheEnd{0, -0.785, 0, -2.356, 0, 1.571, 2.83};

TEST(MotionGuardTest, HoldsAJointAtTheEndOfItsRange) {
  const Guarded guarded(kAtTheEnd, {0, 0, 0, 0, 0, -0.5});
  EXPECT_GE(guarded.allowed[5], 0);
  EXPECT_EQ(guarded.active, (ActiveBound{Bound::kJointEnd, 7}));
}

TEST(MotionGuardTest, LetsAJointComeBackFromTheEndOfItsRange) {
  EXPECT_NEAR(Guarded(kAtTheEnd, {0, 0, 0, 0, 0, 0.5}).allowed[5], 0.5, 1e-9);
}

TEST(MotionGuardTest, CountsJointsOfReferenceAndArm) {
  JointVector q = kAtTheEnd;
  q[6] = 2.4;
  const Vector6 turn{0, 0, 0, 0, 0, -0.5};
  EXPECT_NEAR(Guarded(q, turn, q).allowed[5], -0.5, 1e-9);
  EXPECT_GE(Guarded(q, turn, kAtTheEnd).allowed[5], 0);
  EXPECT_GE(Guarded(kAtTheEnd, turn, q).allowed[5], 0);
}

TEST(MotionGuardTest, HoldsTheHandBeforeItsOwnArm) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  JointVector folded{0, -0.6, 0, -2.9, 0, 2.4, 0.785};
  while (model::SelfDistance(folded, true) > 0.07 && folded[5] > 0) folded[5] -= 0.01;
  const double apart = model::SelfDistance(folded, true);
  ASSERT_GT(apart, MotionGuard::kSelfMargin);
  ASSERT_LT(apart, 0.07);
  // Any fast twist that the guard allows leaves the distance what the barrier promises.
  const Random random(5, RandomStream::kTest);
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    Vector6 twist;
    for (std::uint32_t i = 0; i < 6; ++i) twist[i] = (i < 3 ? 0.2 : 0.6) * random.Normal(trial, i);
    const Vector6 allowed = Guarded(folded, twist).allowed;
    constexpr double kAhead = 1e-4;  // s
    JointVector there = folded;
    const model::Jacobian J = arm.ZeroJacobian(model::Frame::kEndEffector, folded);
    const Eigen::Map<const Eigen::Matrix<double, 6, 7>> jacobian(J.data());
    const Eigen::Matrix<double, 7, 1> dq = jacobian.completeOrthogonalDecomposition().solve(
        Eigen::Map<const Eigen::Matrix<double, 6, 1>>(allowed.data()));
    for (std::size_t i = 0; i < there.size(); ++i) {
      there[i] += kAhead * dq[static_cast<Eigen::Index>(i)];
    }
    const double closing = (apart - model::SelfDistance(there, true)) / kAhead;
    EXPECT_LE(closing, MotionGuard::kDecay * (apart - MotionGuard::kSelfMargin) + 2e-3);
  }
}

/// A wall three centimetres before the end effector along x.
struct Wall final : Surroundings {
  std::size_t Near(const JointVector& q, const BasePose& /*base*/, double /*horizon*/,
                   std::span<Obstacle> near) noexcept override {
    const model::Jacobian J = model::ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, q);
    near[0].distance = 0.03;
    for (std::size_t i = 0; i < kJoints; ++i) near[0].gradient[i] = -J[6 * i];
    return 1;
  }
};

TEST(MotionGuardTest, SlowsTheHandBeforeAFixedBodyAndLetsItSlideAlong) {
  Wall wall;
  const Guarded guarded(test::kReady, {0.2, 0.1, 0, 0, 0, 0}, test::kReady, &wall);
  EXPECT_NEAR(guarded.allowed[0], MotionGuard::kDecay * (0.03 - MotionGuard::kSceneMargin), 1e-3);
  EXPECT_NEAR(guarded.allowed[1], 0.1, 1e-3);
  EXPECT_EQ(guarded.active.bound, Bound::kScene);
}

/// The speed that a joint of kAtTheEnd's arm may have.
double AllowedTurn(std::size_t joint, double speed, ActiveBound& active, Wall* wall = nullptr) {
  MotionGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits(), true, wall);
  RobotState state;
  state.q = kAtTheEnd;
  state.F_T_EE = kIdentityTransform;
  TurnBounds bounds;
  guard.AddTo(bounds, joint, {.q = kAtTheEnd}, state);
  return bounds.Closest(speed, active);
}

TEST(TurnBoundsTest, NeverTurnsAJointByItself) {
  TurnBounds bounds;
  bounds.Add(2, -0.5, {Bound::kSelf});
  ActiveBound active;
  EXPECT_EQ(bounds.Closest(0.3, active), 0);
  EXPECT_EQ(active.bound, Bound::kSelf);
  EXPECT_EQ(bounds.Closest(-0.3, active), -0.3);
  EXPECT_EQ(active.bound, Bound::kNone);
}

TEST(TurnBoundsTest, IgnoresABoundThatTheJointDoesNotChange) {
  TurnBounds bounds;
  for (const double rounding : {0.0, 1e-9, -1e-9}) bounds.Add(rounding, -1e-4, {Bound::kScene});
  ActiveBound active;
  for (const double turn : {0.3, -0.3}) EXPECT_EQ(bounds.Closest(turn, active), turn);
}

TEST(MotionGuardTest, HoldsAJointThatTurnsAloneBeforeItsEnd) {
  ActiveBound active;
  const double left = 2.8973 - 2.83 - MotionGuard::kJointMargin;
  ASSERT_LT(left, 0);
  EXPECT_EQ(AllowedTurn(6, 0.5, active), 0);
  EXPECT_EQ(active, (ActiveBound{Bound::kJointEnd, 7}));
  EXPECT_EQ(AllowedTurn(6, -0.5, active), -0.5);
}

TEST(MotionGuardTest, SlowsAJointThatTurnsAloneBeforeAFixedBody) {
  Wall wall;
  const model::Jacobian J =
      model::ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, kAtTheEnd);
  const double ahead = J[6 * 1];  // of the end effector, m/rad: joint 2 takes it to the wall
  ASSERT_GT(ahead, 0.1);
  ActiveBound active;
  EXPECT_NEAR(AllowedTurn(1, 0.5, active, &wall),
              MotionGuard::kDecay * (0.03 - MotionGuard::kSceneMargin) / ahead, 1e-9);
  EXPECT_EQ(active.bound, Bound::kScene);
}

}  // namespace
}  // namespace twin::teleop::teleop_shaping_test
