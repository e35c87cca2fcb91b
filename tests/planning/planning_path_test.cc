#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planning/joint_space.h"
#include "planning/motion_checker.h"
#include "planning/path_timing.h"
#include "planning/planning_fixture.h"
#include "planning/shortcuts.h"
#include "planning/tree_search.h"
#include "support/fr3_limits.h"
#include "twin/core/error.h"
#include "twin/planning/random_goal.h"

namespace twin::planning::planning_path_test {
namespace {

constexpr double kClearance = 0.01;
constexpr std::uint64_t kMany = 1'000'000;

class PathTest : public testing::Test {
 protected:
  JointVector Free(std::uint64_t seed) { return RandomGoal(world_, limits_, seed); }

  /// A path of several straight ways between random free configurations.
  std::vector<JointVector> Found(std::uint64_t seed) {
    return FindPath({.start = Free(2 * seed),
                     .goals = {Free(2 * seed + 1)},
                     .bounds = {limits_.q_min, limits_.q_max},
                     .seed = seed},
                    checker_);
  }

  CollisionWorld world_{Options("clutter.xml")};
  const JointLimits limits_ = test::PandaLimits();
  MotionChecker checker_{world_, kClearance, kMany};
};

TEST_F(PathTest, AWayThatIsFoundFreeIsFreeAllAlong) {
  int free = 0;
  for (std::uint64_t n = 0; n < 60; ++n) {
    const JointVector from = Free(n);
    const JointVector to = Between(from, Free(n + 1000), 0.4);
    if (!checker_.IsFree(from, to)) continue;
    ++free;
    const int fine = 10 * static_cast<int>(world_.Travel(from, to) / (2 * kClearance));
    for (int i = 0; i <= fine; ++i) {
      ASSERT_TRUE(world_.IsFree(Between(from, to, static_cast<double>(i) / fine))) << n;
    }
  }
  EXPECT_GT(free, 10);
}

TEST_F(PathTest, AWayIsCheckedAtPointsTwoClearancesApart) {
  JointVector to = kReady;
  to[0] += 0.5;
  const std::uint64_t before = world_.checks();
  ASSERT_TRUE(checker_.IsFree(kReady, to));
  const double steps = std::ceil(world_.reach()[0] * 0.5 / (2 * kClearance));
  EXPECT_EQ(world_.checks() - before, static_cast<std::uint64_t>(steps));
}

TEST_F(PathTest, BeyondTheBudgetNothingIsFree) {
  MotionChecker checker(world_, kClearance, 3);
  EXPECT_TRUE(checker.IsFree(kReady));
  EXPECT_EQ(checker.left(), 2);
  JointVector to = kReady;
  to[0] += 0.5;
  EXPECT_FALSE(checker.IsFree(kReady, to));
  EXPECT_TRUE(checker.IsExhausted());
  EXPECT_FALSE(checker.IsFree(kReady));
  EXPECT_EQ(checker.left(), 0);
}

TEST_F(PathTest, ShorteningKeepsTheEndsAndThePathFree) {
  double before = 0;
  double after = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    std::vector<JointVector> path = Found(seed);
    ASSERT_GE(path.size(), 2);
    const JointVector start = path.front();
    const JointVector goal = path.back();
    before += Length(path);
    Shorten(path, checker_, seed, {});
    after += Length(path);
    EXPECT_EQ(path.front(), start);
    EXPECT_EQ(path.back(), goal);
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (int k = 0; k <= 200; ++k) {
        ASSERT_TRUE(world_.IsFree(Between(path[i - 1], path[i], k / 200.0)));
      }
    }
  }
  EXPECT_LT(after, 0.7 * before);
}

TEST_F(PathTest, ShorteningLeavesTheChecksItIsToldToLeave) {
  std::vector<JointVector> path = Found(1);
  MotionChecker checker(world_, kClearance, 2000);
  Shorten(path, checker, 1, {.attempts = 1000, .keep_checks = 1500});
  EXPECT_GT(checker.left(), 1000);  // what was begun is brought to its end
}

TEST_F(PathTest, StopAndGoStaysOnTheStraightWaysAndUsesTheSharesUp) {
  const std::vector<JointVector> path{kReady, Drawn(1, 1), Drawn(1, 2)};
  const reference::Timing pace{
      .velocity_scale = 0.4, .acceleration_scale = 0.15, .jerk_scale = 0.2};
  const TimedPath timed = StopAndGo(path, pace, limits_);
  ASSERT_EQ(timed.waypoints.size(), 3);
  EXPECT_TRUE(timed.waypoints[1].stop);
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto& peaks = timed.trajectory.peaks();
    EXPECT_LE(peaks.velocity[i], pace.velocity_scale);
    EXPECT_LE(peaks.acceleration[i], pace.acceleration_scale);
    EXPECT_LE(peaks.jerk[i], pace.jerk_scale);
    largest = std::max({largest, peaks.velocity[i] / pace.velocity_scale,
                        peaks.acceleration[i] / pace.acceleration_scale,
                        peaks.jerk[i] / pace.jerk_scale});
  }
  EXPECT_GT(largest, 0.999);
  const Duration turn = *timed.waypoints[1].at;
  for (int k = 1; k < 50; ++k) {
    const JointVector q = timed.trajectory.Sample(turn * k / 50).q;
    const double share = (q[0] - path[0][0]) / (path[1][0] - path[0][0]);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(q[i], Between(path[0], path[1], share)[i], 1e-9);
    }
  }
}

TEST_F(PathTest, KeepsVelocityLimitsThatDependOnThePosition) {
  const JointLimits limits = test::Fr3Limits();
  JointVector near_the_end = kReady;
  near_the_end[0] = limits.q_max[0] - 0.05;
  near_the_end[5] = limits.q_max[5] - 0.05;
  const std::vector<JointVector> path{kReady, near_the_end, {0.4, -0.5, 0.2, -2.0, 0.1, 1.6, 0.9}};
  const reference::Timing pace{.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1};
  const auto through = RunThrough({{.q = path[0]}, {.q = path[1]}, {.q = path[2]}}, pace, limits);
  ASSERT_TRUE(through);
  const TimedPath stops = StopAndGo(path, pace, limits);
  for (const reference::Trajectory* timed : {&through->trajectory, &stops.trajectory}) {
    double largest = 0;
    for (Duration t = kCycle; t < timed->duration(); t += kCycle) {
      const auto target = timed->Sample(t);
      for (std::size_t i = 0; i < kJoints; ++i) {
        const double limit = limits.VelocityLimit(i, target.q[i], target.dq[i]);
        largest = std::max(largest, std::abs(target.dq[i]) / limit);
      }
    }
    EXPECT_LE(largest, 1);
    EXPECT_GT(largest, 0.9);
  }
  near_the_end[3] = limits.q_max[3] - 0.01;
  EXPECT_THROW((void)StopAndGo({kReady, near_the_end}, pace, limits), InputError);
}

TEST_F(PathTest, PointsThatCoincideDoNoHarm) {
  JointVector to = kReady;
  to[0] += 0.5;
  std::vector<JointVector> path{kReady, kReady, to, to, to};
  const TimedPath timed = TimePath(path, {}, limits_, checker_);
  EXPECT_EQ(timed.trajectory.goal(), to);
  Shorten(path, checker_, 1, {});
  EXPECT_EQ(path, (std::vector<JointVector>{kReady, to}));
}

TEST_F(PathTest, RunThroughPassesThePointsAndIsFasterThanStopAndGo) {
  const JointVector second{0.4, -0.5, 0.2, -2.0, 0.1, 1.6, 0.9};
  const JointVector third{0.9, -0.3, 0.3, -1.8, 0.3, 1.8, 1.2};
  const std::vector<JointVector> path{kReady, second, third};
  const auto timed = RunThrough({{.q = path[0]}, {.q = path[1]}, {.q = path[2]}}, {}, limits_);
  ASSERT_TRUE(timed);
  EXPECT_LT(timed->trajectory.duration(), StopAndGo(path, {}, limits_).trajectory.duration());
  const JointVector q = timed->trajectory.Sample(*timed->waypoints[1].at).q;
  EXPECT_LT(Distance(q, second), 1e-9);
}

TEST_F(PathTest, RunThroughTellsThatASplineLeavesTheLimits) {
  // To the very edge of joint 2 and back from there at a sharp angle.
  JointVector edge = kReady;
  edge[1] = limits_.q_max[1] - 1e-6;
  edge[0] = 0.5;
  JointVector back = edge;
  back[1] -= 1e-3;
  back[0] = 1.5;
  EXPECT_FALSE(RunThrough({{.q = kReady}, {.q = edge}, {.q = back}}, {}, limits_));
}

}  // namespace
}  // namespace twin::planning::planning_path_test
