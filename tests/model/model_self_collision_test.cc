#include "twin/model/self_collision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "model/model_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"

namespace twin::model::model_self_collision_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Waypoints of models/scenarios/trajectories, canonical and brisk.
constexpr std::array<JointVector, 16> kWorkPoses{
    {{0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483},
     {0.793, -0.345, 0.161, -2.571, 0.594, 2.956, 0.503},
     {0.627, 0.096, -0.204, -1.103, -0.804, 1.553, -0.11},
     {-0.08, -0.163, -0.546, -2.656, 1.346, 3.194, -0.321},
     {-0.111, 0.152, -0.351, -1.093, 0.948, 1.157, 0.694},
     {-1.664, -0.364, 0.832, -2.618, 0.928, 2.145, 2.497},
     {0.162, 0.652, -0.9, -1.104, 0.444, 2.259, 0.433},
     {-0.006, -1.16, 0.459, -2.538, 0.485, 2.098, -0.358},
     {-0.434, -0.41, -0.532, -1.809, 0.16, 2.223, 0.949},
     {0.277, -0.062, -0.524, -2.155, -0.011, 1.449, -0.131},
     {-0.492, -0.179, 0.131, -1.959, -0.445, 2.356, 0.967},
     {0.138, -0.1, -0.745, -2.213, -0.128, 1.609, 0.442},
     {-0.81, -0.065, 0.243, -1.914, 0.738, 2.492, 1.537},
     {0.123, -0.702, -0.233, -2.522, 0.363, 1.708, 0.661},
     {0.082, -0.699, 0.165, -1.949, 0.134, 2.218, 1.195},
     {0.746, -0.17, -0.135, -1.933, -0.478, 1.511, 0.469}}};

/// The forearm folded down beside the shoulder.
constexpr JointVector kFolded{0, 0, 1.57, -3.05, 0, 1.5, 0};

/// A point of a link in the base.
Vector3 InBase(Frame frame, const JointVector& q, const Vector3& p) {
  const Transform X = ArmModel::Panda().Pose(frame, q);
  Vector3 in_base;
  for (std::size_t r = 0; r < 3; ++r) {
    in_base[r] = X[r] * p[0] + X[4 + r] * p[1] + X[8 + r] * p[2] + X[12 + r];
  }
  return in_base;
}

double Distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

TEST(SelfDistanceTest, PosesOfOrdinaryWorkAreClear) {
  for (const JointVector& q : kWorkPoses) EXPECT_GT(SelfDistance(q, true), 0.05);
}

TEST(SelfDistanceTest, AFoldedArmMeetsItself) {
  EXPECT_LT(SelfDistance(kFolded, true), 0);
  EXPECT_LT(SelfDistance(kFolded, false), 0);
}

TEST(SelfDistanceTest, TheHandIsAPartOnlyWhenItIsThere) {
  // Joint 6 at its lower end turns the flange back along the forearm.
  const JointVector q{0, -0.3, 0, -2, 0, 0, 0.785};
  EXPECT_LT(SelfDistance(q, true), 0.02);
  EXPECT_GT(SelfDistance(q, false), 0.1);
  for (std::uint64_t i = 0; i < 500; ++i) {
    EXPECT_LE(SelfDistance(SampleOf(i).q, true), SelfDistance(SampleOf(i).q, false));
  }
}

TEST(SelfDistanceTest, IsTheGapBetweenFingersAndColumn) {
  // The fingers' capsule, 22 mm thick, 50 mm to either side, 90 mm beyond the flange, comes towards
  // the column's, 75 mm thick between 0.1 and 0.3 m above the floor. The gap by points along both.
  int nearest_there = 0;
  for (int step = 0; step <= 40; ++step) {
    const JointVector q{0, -0.9 - 0.01 * step, 0, -2.9, 0, 1.2, 0.785};
    double gap = 1;
    for (int a = -50; a <= 50; ++a) {
      const double y = 1e-3 * a * std::sqrt(0.5);
      const Vector3 fingers = InBase(Frame::kFlange, q, {y, y, 0.09});
      for (int b = 100; b <= 300; ++b) gap = std::min(gap, Distance(fingers, {0, 0, 1e-3 * b}));
    }
    gap -= 0.022 + 0.075;
    const double distance = SelfDistance(q, true);
    EXPECT_LE(distance, gap + 1e-12);
    if (distance > gap - 2e-5) ++nearest_there;
  }
  EXPECT_GT(nearest_there, 5) << "in some of these poses nothing else is nearer";
}

TEST(SelfDistanceTest, DoesNotDependOnTheFirstJointButForTheBase) {
  // The base plate alone is not round: far above it only the pose of the rest counts.
  for (const double q1 : {-2.8, -1.0, 0.3, 2.0}) {
    JointVector q = kReady;
    q[0] = q1;
    EXPECT_NEAR(SelfDistance(q, true), SelfDistance(kReady, true), 1e-12);
  }
}

TEST(SelfDistanceTest, IsCutAtTheHorizon) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    const JointVector q = SampleOf(i).q;
    const double distance = SelfDistance(q, true);
    for (const double horizon : {0.0, 0.01, 0.1, 1.0}) {
      EXPECT_DOUBLE_EQ(SelfDistance(q, true, horizon), std::min(distance, horizon));
    }
  }
}

TEST(SelfDistanceTest, WhatIsNoNumberIsNotNear) {
  EXPECT_EQ(SelfDistance(JointVector{0, kNaN, 0, -2, 0, 1.5, 0}, true, 0.5), 0.5);
}

TEST(SelfDistanceTest, ChangesNoFasterThanThePartsTravel) {
  // What the watch relies on, over random ways of every length.
  constexpr JointVector kReach{1.2, 1.2, 0.9, 0.9, 0.4, 0.4, 0.25};
  const Random random(7, RandomStream::kTest);
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const JointVector q = SampleOf(i).q;
    JointVector moved = q;
    double bound = 0;
    const double size = std::pow(10, -4 * random.Uniform(i, 20));
    for (std::size_t k = 0; k < kJoints; ++k) {
      const double step = size * (2 * random.Uniform(i, static_cast<std::uint32_t>(k)) - 1);
      moved[k] += step;
      bound += kReach[k] * std::abs(step);
    }
    EXPECT_LE(std::abs(SelfDistance(moved, true) - SelfDistance(q, true)), bound + 1e-12);
  }
}

TEST(SelfDistanceWatchTest, SeesEveryApproachThatTheDistanceShows) {
  // Ways through the whole workspace at up to 2 mrad a cycle.
  int near = 0;
  for (std::uint64_t way = 0; way < 30; ++way) {
    SelfDistanceWatch watch(true);
    const JointVector from = SampleOf(2 * way).q;
    const JointVector to = SampleOf(2 * way + 1).q;
    for (int k = 0; k <= 2000; ++k) {
      JointVector q;
      for (std::size_t i = 0; i < kJoints; ++i) q[i] = from[i] + (to[i] - from[i]) * k / 2000;
      const double distance = SelfDistance(q, true);
      const double seen = watch.Update(q, q, 0.01);
      ASSERT_EQ(seen < 0.01, distance < 0.01);
      if (seen < 0.01) {
        ASSERT_EQ(seen, distance);
        ++near;
      }
      ASSERT_LE(seen, distance + 1e-12);
    }
  }
  EXPECT_GT(near, 500);
}

TEST(SelfDistanceWatchTest, KnowsNothingBeforeTheFirstPose) {
  SelfDistanceWatch watch(true);
  EXPECT_EQ(watch.Update(JointVector{}, JointVector{}, 0.0), SelfDistance(JointVector{}, true));
  SelfDistanceWatch other(true);
  EXPECT_LT(other.Update(kFolded, kFolded, 0.01), 0);
}

TEST(SelfDistanceWatchTest, GoesOnAfterWhatIsNoNumber) {
  SelfDistanceWatch watch(true);
  (void)watch.Update(kReady, kReady, 0.01);
  JointVector bad = kReady;
  bad[2] = kNaN;
  (void)watch.Update(bad, bad, 0.01);
  EXPECT_LT(watch.Update(kFolded, kFolded, 0.01), 0);
}

TEST(SelfDistanceWatchTest, TakesNoMemory) {
  SelfDistanceWatch watch(true);
  JointVector q = kReady;
  double sum = 0;
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    q[1] -= 1e-3;
    sum += watch.Update(q, q, 0.01);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_NE(sum, 0);
}

}  // namespace
}  // namespace twin::model::model_self_collision_test
