#include "twin/planning/random_goal.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planning/planning_fixture.h"
#include "twin/core/error.h"

namespace twin::planning::planning_random_goal_test {
namespace {

using testing::HasSubstr;

TEST(RandomGoalTest, IsFreeFarEnoughAndInsideTheLimits) {
  CollisionWorld world(Options("clutter.xml"));
  const JointLimits limits = test::PandaLimits();
  const RandomGoalOptions options{
      .from = kReady, .least_distance = 4, .clearance = 0.03, .limit_margin = 0.2};
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const JointVector q = RandomGoal(world, limits, seed, options);
    EXPECT_TRUE(world.IsFree(q, options.clearance)) << seed;
    double squared = 0;
    for (std::size_t i = 0; i < kJoints; ++i) {
      squared += std::pow(q[i] - kReady[i], 2);
      EXPECT_GE(q[i], limits.q_min[i] + options.limit_margin);
      EXPECT_LE(q[i], limits.q_max[i] - options.limit_margin);
    }
    EXPECT_GE(std::sqrt(squared), options.least_distance);
  }
}

TEST(RandomGoalTest, DependsOnTheSeedAlone) {
  CollisionWorld world(Options("clutter.xml"));
  const JointVector first = RandomGoal(world, test::PandaLimits(), 1);
  const JointVector second = RandomGoal(world, test::PandaLimits(), 2);
  EXPECT_NE(first, second);
  EXPECT_EQ(RandomGoal(world, test::PandaLimits(), 1), first);
}

TEST(RandomGoalTest, SaysWhenThereIsNone) {
  CollisionWorld world(Options("clutter.xml"));
  EXPECT_THAT(MessageOf<InputError>([&] {
                static_cast<void>(RandomGoal(world, test::PandaLimits(), 1,
                                             {.clearance = 0.9, .most_draws = 50}));
              }),
              HasSubstr("none of 50 random configurations"));
  EXPECT_THAT(MessageOf<InputError>([&] {
                static_cast<void>(RandomGoal(world, test::PandaLimits(), 1, {.least_distance = 6}));
              }),
              HasSubstr("least_distance"));
}

}  // namespace
}  // namespace twin::planning::planning_random_goal_test
