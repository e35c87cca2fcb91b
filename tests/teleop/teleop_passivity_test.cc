#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include <gtest/gtest.h>

#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/teleop/force_feedback.h"

namespace twin::teleop::teleop_passivity_test {
namespace {

constexpr double kT = kCycleSeconds;

RobotState Pressed(double force) {
  RobotState state;
  state.O_F_ext_hat_K = {0, 0, -force, 0, 0, 0};  // the robot pushes downwards
  return state;
}

TEST(ReflectedWrenchTest, PushesBackAgainstWhatTheRobotPushesOn) {
  ReflectedWrench reflected({.scale = 0.5, .dead_force = 4, .most_force = 100});
  Vector6 f{};
  for (int i = 0; i < 1000; ++i) f = reflected.Next(Pressed(24), false, true, kT);
  EXPECT_NEAR(f[2], 0.5 * (24 - 4), 1e-6);
}

TEST(ReflectedWrenchTest, TellsNothingOfWhatAFreeArmIsSaidToFeel) {
  ReflectedWrench reflected({.dead_force = 4});
  for (int i = 0; i < 1000; ++i) reflected.Next(Pressed(3.9), false, true, kT);
  EXPECT_EQ(reflected.Next(Pressed(3.9), false, true, kT), Vector6{});
}

TEST(ReflectedWrenchTest, IsLimitedByItsNorm) {
  ReflectedWrench reflected({.scale = 1, .most_force = 5});
  Vector6 f{};
  for (int i = 0; i < 2000; ++i) f = reflected.Next(Pressed(500), false, true, kT);
  EXPECT_NEAR(HalfNorm(f, 0), 5, 1e-6);
}

TEST(ReflectedWrenchTest, IsLowPassed) {
  const FeedbackConfig config{.scale = 1, .cutoff_hz = 10, .dead_force = 0, .most_force = 100};
  ReflectedWrench reflected(config);
  const double tau = 1 / (2 * std::numbers::pi * config.cutoff_hz);  // s
  Vector6 f{};
  const int steps = 16;
  for (int i = 0; i < steps; ++i) f = reflected.Next(Pressed(10), false, true, kT);
  EXPECT_NEAR(f[2], 10 * (1 - std::exp(-steps * kT / tau)), 1e-9);
}

/// A hand that holds a handle: its wish is a motion of the arm, whose wall answers late.
///   m x'' = k (x_hand - x) - b x' + f,   f(t) = port( -k_wall max(0, x(t - delay)) )
struct Hand {
  double delay_s = 0.6;  ///< there and back
  bool passive = true;
  double least = 0;  ///< energy
  double swing = 0;  ///< largest speed in the last second, m/s
  double penetration = 0;

  void Press() {
    FeedbackConfig config{.most_force = 30, .passive = passive};
    PassivePort port(config);
    constexpr double kMass = 0.3;
    constexpr double kHand = 120;
    constexpr double kDamping = 3;
    constexpr double kWall = 900;
    std::deque<double> on_the_way(static_cast<std::size_t>(delay_s / kT), -0.05);
    double x = -0.05;
    double v = 0;
    double E = 0;
    double f = 0;
    for (int i = 0; i < 20'000; ++i) {
      const double wanted = i < 2000 ? -0.05 + 0.03 * i * kT : 0.01;
      const double a = (kHand * (wanted - x) - kDamping * v + f) / kMass;
      v += kT * a;
      x += kT * v;
      E -= f * kT * v;  // a second account, of the same work
      least = std::min(least, E);
      on_the_way.push_back(x);
      const double wall = -kWall * std::max(0.0, on_the_way.front());
      on_the_way.pop_front();
      f = port.Next({x, 0, 0, 0, 0, 0},
                    {std::clamp(wall, -config.most_force, config.most_force), 0, 0, 0, 0, 0},
                    kT)[0];
      if (i >= 19'000) swing = std::max(swing, std::abs(v));
    }
    EXPECT_NEAR(port.energy()[0], E, 1e-9);
    penetration = x;
  }
};

TEST(PassivePortTest, GivesNoMoreThanItsReserveAtAStiffWallSixHundredMillisecondsAway) {
  Hand hand;
  hand.Press();
  EXPECT_GE(hand.least, -FeedbackConfig().reserve - 1e-3);
}

TEST(PassivePortTest, LetsTheHandComeToRestThere) {
  Hand hand;
  hand.Press();
  EXPECT_LT(hand.swing, 0.01);
}

TEST(PassivePortTest, WithoutItTheHandSwingsAndGetsEnergyWithoutEnd) {
  Hand hand{.passive = false};
  hand.Press();
  EXPECT_LT(hand.least, -0.5);
  EXPECT_GT(hand.swing, 0.1);
}

TEST(PassivePortTest, BoundsWhatARandomHandGetsFromARandomWire) {
  const FeedbackConfig config{};
  PassivePort port(config);
  const Random random(11, RandomStream::kTest);
  Vector6 x{};
  Vector6 v{};
  Vector6 f{};
  double fastest = 0;
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    for (std::uint32_t axis = 0; axis < 6; ++axis) {
      // A hand below some ten hertz, and forces that are whatever they like.
      v[axis] += 0.05 * (0.3 * random.Normal(i, axis) - v[axis]);
      x[axis] += kT * v[axis];
      fastest = std::max(fastest, std::abs(v[axis]));
      if (i % 50 == 0) f[axis] = (axis < 3 ? 5 : 0.3) * (2 * random.Uniform(i, 10 + axis) - 1);
    }
    port.Next(x, f, kT);
  }
  const double one_turn = config.most_force * fastest * kT;
  EXPECT_GE(port.least_energy(), -config.reserve - 2 * one_turn);
}

TEST(PassivePortTest, LeavesAWrenchAloneThatOpposesTheMotion) {
  PassivePort port(FeedbackConfig{});
  port.Next({}, {}, kT);
  EXPECT_EQ(port.Next({0.001, 0, 0, 0, 0, 0}, {-3, 0, 0, 0, 0, 0}, kT)[0], -3);
}

TEST(PassivePortTest, PaysADebtBackByDamping) {
  PassivePort port({.reserve = 1e-6});
  port.Next({}, {5, 0, 0, 0, 0, 0}, kT);
  // 5 mJ were given.
  EXPECT_LT(port.Next({0.001, 0, 0, 0, 0, 0}, {5, 0, 0, 0, 0, 0}, kT)[0], 0);
}

}  // namespace
}  // namespace twin::teleop::teleop_passivity_test
