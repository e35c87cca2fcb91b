#include "twin/reference/rejoining_generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference::reference_rejoining_generator_test {
namespace {

constexpr double kT = kCycleSeconds;

/// Joint 1's reference as the robot holds it, and a source's.
class Following {
 public:
  Following() : limits_(test::PandaLimits()), generator_(limits_) {}

  double (*source)(double t) = [](double /*t*/) { return 0.0; };

  /// One cycle. @param lost  whether the command is.
  void Step(bool lost = false) {
    ++k_;
    Played<JointVector> r{};
    for (int i = 0; i < 4; ++i) r[i][0] = source(std::max(0, k_ - i) * kT);
    JointVector q{};
    JointVector dq{};
    JointVector ddq{};
    q[0] = x.q;
    dq[0] = x.dq;
    ddq[0] = x.ddq;
    const double q_c = generator_.Next(r, q, dq, ddq)[0];
    if (lost) {
      x = ViableAxis::Step(x, 0);
      jerk = 0;
      return;
    }
    const double dq_c = (q_c - x.q) / kT;
    const double ddq_c = (dq_c - x.dq) / kT;
    jerk = (ddq_c - x.ddq) / kT;
    x = {q_c, dq_c, ddq_c};
  }
  /// Of the robot's reference from the source's, rad.
  [[nodiscard]] double error() const { return x.q - source(k_ * kT); }

  AxisState x;
  double jerk = 0;

 private:
  JointLimits limits_;
  RejoiningGenerator generator_;
  int k_ = 0;
};

TEST(RejoiningGeneratorTest, FollowsItsSourceExactlyWhileEveryCommandIsTaken) {
  Following following;
  following.source = [](double t) { return 0.2 * (1 - std::cos(3 * t)); };
  for (int k = 0; k < 3000; ++k) {
    following.Step();
    ASSERT_NEAR(following.error(), 0, 1e-12) << k;
  }
}

TEST(RejoiningGeneratorTest, RejoinsAfterLossesWithinItsBoundsAndStaysThere) {
  const JointLimits limits = test::PandaLimits();
  Following following;
  following.source = [](double t) { return 0.2 * (1 - std::cos(3 * t)); };
  for (int k = 0; k < 500; ++k) following.Step();
  for (int k = 0; k < 19; ++k) following.Step(/*lost=*/true);
  const double left = std::abs(following.error());
  EXPECT_GT(left, 1e-7);
  for (int k = 0; k < 600; ++k) {
    const double before = following.x.ddq;
    following.Step();
    // The source's own jerk is 5.4 rad/s^3.
    EXPECT_LE(std::abs(following.jerk), RejoiningGenerator::kShare * limits.dddq_max[0] + 6) << k;
    EXPECT_LE(std::abs(before), limits.ddq_max[0]);
  }
  EXPECT_NEAR(following.error(), 0, 1e-6);
}

/// How an offset of the source is closed.
struct Closing {
  double overshoot = 0;  ///< rad
  int cycles = 0;        ///< until the error stays below 1e-4 of the offset
  double most_dq = 0;    ///< rad/s
  double most_ddq = 0;   ///< rad/s^2
};
Closing Close(double offset) {
  Following following;
  following.x.q = offset;
  Closing closing;
  for (int k = 1; k <= 8000; ++k) {
    following.Step();
    closing.overshoot = std::max(closing.overshoot, -following.error() * (offset > 0 ? 1 : -1));
    closing.most_dq = std::max(closing.most_dq, std::abs(following.x.dq));
    closing.most_ddq = std::max(closing.most_ddq, std::abs(following.x.ddq));
    if (std::abs(following.error()) > 1e-4 * std::abs(offset)) closing.cycles = k;
  }
  return closing;
}

TEST(RejoiningGeneratorTest, ClosesAnOffsetWithoutOvershoot) {
  for (const double offset : {1e-4, -3e-3, 0.05, -0.5, 1.5}) {
    const Closing closing = Close(offset);
    EXPECT_LE(closing.overshoot, 1e-4 * std::abs(offset)) << offset;
    const JointLimits limits = test::PandaLimits();
    EXPECT_LE(closing.most_dq, 1.01 * RejoiningGenerator::kMostShare * limits.dq_max[0]);
    EXPECT_LE(closing.most_ddq, 1.01 * RejoiningGenerator::kMostShare * limits.ddq_max[0]);
  }
}

TEST(RejoiningGeneratorTest, DoesNotOvershootASourceThatAcceleratesMeanwhile) {
  // At 0.65 of its acceleration limit, and as much the other way.
  Following following;
  following.source = [](double t) { return 0.2 * (1 - std::cos(7 * t)); };
  following.x.q = -0.5;
  for (int k = 0; k < 3000; ++k) {
    following.Step();
    ASSERT_LE(following.error(), 1e-9) << k;
  }
  EXPECT_NEAR(following.error(), 0, 1e-9);
}

TEST(RejoiningGeneratorTest, TakesItsShareOfASourceThatLeavesLess) {
  // Constant, at 0.8 of the speed limit.
  const double dq_max = test::PandaLimits().dq_max[0];
  Following following;
  following.source = [](double t) { return 0.8 * 2.175 * t; };
  for (int k = 0; k < 10; ++k) following.Step();  // its begin is a jump of the velocity
  following.x = {following.x.q - 0.5, 0.8 * dq_max, 0};
  double fastest = 0;
  for (int k = 0; k < 1000; ++k) {
    following.Step();
    fastest = std::max(fastest, following.x.dq);
  }
  EXPECT_NEAR(fastest, (0.8 + RejoiningGenerator::kVelocityShare) * dq_max, 0.01 * dq_max);
}

TEST(RejoiningGeneratorTest, ClosesASmallOffsetTenTimesFasterThanLambda) {
  // lambda = 1e-3 needs ln(1e4) / lambda = 9210 cycles to a 10^-4th.
  EXPECT_LT(Close(1e-3).cycles, 900);
}

TEST(RejoiningGeneratorTest, ClosesALargeOffsetAboutAsFastAsItsBoundsAllow) {
  // At most V_c, with ramps of A_c up and of 0.4 A_c down.
  const JointLimits limits = test::PandaLimits();
  const double v = RejoiningGenerator::kMostShare * limits.dq_max[0];
  const double a = RejoiningGenerator::kMostShare * limits.ddq_max[0];
  const double least = 1.5 / v + v / (2 * a) + v / (2 * RejoiningGenerator::kShare * a);
  EXPECT_LT(Close(1.5).cycles * kT, 1.3 * least);
}

/// A source's poses: x and the turn about z swing together.
Transform SwingingPose(int k) {
  const double s = 0.2 * (1 - std::cos(3 * std::max(k, 0) * kT));
  return model::Pose(model::Exp({0, 0, s}), {0.4 + s, 0, 0.5});
}

/// The robot's commanded pose with its differences, as INT forms them.
struct PoseReference {
  RobotState state;

  PoseReference() { state.O_T_EE_c = SwingingPose(0); }
  void Take(const Transform& pose) {
    const Eigen::Vector3d v = (model::Position(pose) - model::Position(state.O_T_EE_c)) / kT;
    const Eigen::Vector3d w = model::TurnBetween(state.O_T_EE_c, pose) / kT;
    const Vector6 twist{v[0], v[1], v[2], w[0], w[1], w[2]};
    for (std::size_t i = 0; i < 6; ++i) {
      state.O_ddP_EE_c[i] = (twist[i] - state.O_dP_EE_c[i]) / kT;
    }
    state.O_dP_EE_c = twist;
    state.O_T_EE_c = pose;
  }
  void Miss() {
    Vector6& d = state.O_dP_EE_c;
    for (std::size_t i = 0; i < 6; ++i) d[i] += kT * state.O_ddP_EE_c[i];
    state.O_T_EE_c =
        model::Turned(state.O_T_EE_c, kT * Eigen::Vector3d(d[3], d[4], d[5]),
                      model::Position(state.O_T_EE_c) + kT * Eigen::Vector3d(d[0], d[1], d[2]));
  }
  [[nodiscard]] double Error(int k) const {
    return std::max((model::Position(state.O_T_EE_c) - model::Position(SwingingPose(k))).norm(),
                    model::TurnBetween(state.O_T_EE_c, SwingingPose(k)).norm());
  }
};

Played<Transform> PosesUpTo(int k) {
  return {SwingingPose(k), SwingingPose(k - 1), SwingingPose(k - 2), SwingingPose(k - 3)};
}

TEST(RejoiningPoseGeneratorTest, FollowsItsSourceExactlyWhileEveryCommandIsTaken) {
  const RejoiningPoseGenerator generator(test::PandaCartesianLimits());
  PoseReference robot;
  for (int k = 1; k < 2000; ++k) {
    robot.Take(generator.Next(PosesUpTo(k), robot.state));
    ASSERT_NEAR(robot.Error(k), 0, 1e-11) << k;
  }
}

TEST(RejoiningPoseGeneratorTest, RejoinsAfterLossesWithinItsShareOfTheLimits) {
  const CartesianLimits limits = test::PandaCartesianLimits();
  const RejoiningPoseGenerator generator(limits);
  PoseReference robot;
  for (int k = 1; k <= 500; ++k) robot.Take(generator.Next(PosesUpTo(k), robot.state));
  for (int k = 501; k < 520; ++k) robot.Miss();
  EXPECT_GT(robot.Error(519), 1e-7);
  for (int k = 520; k < 1200; ++k) {
    const Vector6 before = robot.state.O_ddP_EE_c;
    robot.Take(generator.Next(PosesUpTo(k), robot.state));
    const double jerk = (robot.state.O_ddP_EE_c[0] - before[0]) / kT;
    // The source's own is 5.4 m/s^3.
    EXPECT_LE(std::abs(jerk), RejoiningGenerator::kShare * RejoiningPoseGenerator::kPoseShare *
                                      limits.translation.dddp_max +
                                  6);
  }
  EXPECT_NEAR(robot.Error(1199), 0, 1e-6);
}

TEST(RejoiningGeneratorTest, AllocatesNothing) {
  const RejoiningGenerator generator(test::PandaLimits());
  const RejoiningPoseGenerator poses(test::PandaCartesianLimits());
  const PoseReference robot;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    static_cast<void>(generator.Next({}, {}, {}, {}));
    static_cast<void>(poses.Next(PosesUpTo(i), robot.state));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::reference::reference_rejoining_generator_test
