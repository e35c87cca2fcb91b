#include "twin/planning/planner.h"

#include <bit>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planning/problem_set.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::planning::planning_planner_test {
namespace {

using testing::HasSubstr;

/// A clock that moves on by a millisecond whenever it is read.
class TickingClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const noexcept override {
    now_ += kCycle;
    return now_;
  }

 private:
  mutable Time now_{};
};

std::optional<Plan> PlanOf(const PlanOutcome& outcome) {
  if (const auto* failure = std::get_if<PlanFailure>(&outcome)) {
    ADD_FAILURE() << failure->text;
    return std::nullopt;
  }
  return std::get<Plan>(outcome);
}

PlanFailure FailureOf(const PlanOutcome& outcome) {
  if (const auto* failure = std::get_if<PlanFailure>(&outcome)) return *failure;
  ADD_FAILURE() << "there is a plan";
  return {};
}

/// The bits of what a trajectory does.
std::uint64_t HashOf(const Plan& plan) {
  std::uint64_t hash = 14695981039346656037u;
  for (Duration t{}; t <= plan.trajectory.duration(); t += 10 * kCycle) {
    for (const double q : plan.trajectory.Sample(t).q) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(q)) * 1099511628211u;
    }
  }
  return hash;
}

class PlannerTest : public testing::Test {
 protected:
  CollisionWorld world_{Options("clutter.xml")};
  const JointLimits limits_ = test::PandaLimits();
  TickingClock clock_;
  Planner planner_{world_, limits_, clock_};
};

TEST_F(PlannerTest, PlansAreFreeOfContactByTheEngineItself) {
  EngineView engine(Options("clutter.xml"));
  for (std::uint64_t n = 0; n < 10; ++n) {
    const Problem problem = ProblemOf(world_, n);
    const auto plan = PlanOf(planner_.ToConfiguration(problem.start, problem.goal, n));
    ASSERT_TRUE(plan) << n;
    EXPECT_EQ(FirstContact(engine, plan->trajectory, 0.08), std::nullopt) << n;
    EXPECT_EQ(plan->trajectory.start(), problem.start);
    EXPECT_EQ(plan->trajectory.goal(), problem.goal);
    EXPECT_LE(plan->statistics.checks, PlannerOptions{}.most_checks);
    EXPECT_LE(plan->statistics.path_length, plan->statistics.found_length);
  }
}

TEST_F(PlannerTest, AStraightWayThroughTheCluttersObstaclesIsNotFree) {
  // That the problems above are problems: the check finds what a planner that looks at nothing
  // does.
  EngineView engine(Options("clutter.xml"));
  int blocked = 0;
  for (std::uint64_t n = 0; n < 10; ++n) {
    const Problem problem = ProblemOf(world_, n);
    const reference::Trajectory straight({{.q = problem.start}, {.q = problem.goal}}, {}, limits_);
    blocked += FirstContact(engine, straight, 0.08) ? 1 : 0;
  }
  EXPECT_GE(blocked, 5);
}

TEST_F(PlannerTest, PlansKeepToTheSharesOfTheLimits) {
  PlannerOptions options;
  options.pace = {.velocity_scale = 0.3, .acceleration_scale = 0.1, .jerk_scale = 0.05};
  Planner planner(world_, limits_, clock_, options);
  const Problem problem = ProblemOf(world_, 0);
  const auto plan = PlanOf(planner.ToConfiguration(problem.start, problem.goal, 1));
  ASSERT_TRUE(plan);
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto& peaks = plan->trajectory.peaks();
    EXPECT_LE(peaks.velocity[i], 0.3);
    EXPECT_LE(peaks.acceleration[i], 0.1);
    EXPECT_LE(peaks.jerk[i], 0.05);
    largest = std::max(
        {largest, peaks.velocity[i] / 0.3, peaks.acceleration[i] / 0.1, peaks.jerk[i] / 0.05});
  }
  EXPECT_GT(largest, 0.99);  // and use them
}

TEST_F(PlannerTest, TheSameSeedGivesTheSamePlanToTheBitInAnyOrder) {
  const Problem a = ProblemOf(world_, 2);
  const Problem b = ProblemOf(world_, 7);
  const auto hash = [&](Planner& planner, const Problem& problem, std::uint64_t seed) {
    const auto plan = PlanOf(planner.ToConfiguration(problem.start, problem.goal, seed));
    return plan ? HashOf(*plan) : 0;
  };
  const std::uint64_t a_first = hash(planner_, a, 5);
  const std::uint64_t b_second = hash(planner_, b, 5);
  CollisionWorld other_world(Options("clutter.xml"));
  Planner other(other_world, limits_, clock_);
  const std::uint64_t b_first = hash(other, b, 5);
  const std::uint64_t a_second = hash(other, a, 5);
  EXPECT_EQ(a_first, a_second);
  EXPECT_EQ(b_first, b_second);
  EXPECT_NE(a_first, hash(planner_, a, 6));
}

TEST_F(PlannerTest, AWorldThatHeldSomethingPlansAsBefore) {
  const Problem problem = ProblemOf(world_, 3);
  const auto before = PlanOf(planner_.ToConfiguration(problem.start, problem.goal, 1));
  world_.Attach("box", Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.1, 1});
  world_.Detach();
  const auto after = PlanOf(planner_.ToConfiguration(problem.start, problem.goal, 1));
  ASSERT_TRUE(before && after);
  EXPECT_EQ(HashOf(*before), HashOf(*after));
  EXPECT_EQ(before->statistics.checks, after->statistics.checks);
}

TEST_F(PlannerTest, WhatIsHeldCanBeInTheWay) {
  // Across the table, 30 mm above it with open fingers: free without the box, not with it below
  // the finger tips.
  const JointVector left = Reaching(Down(0.5, -0.06, 0.22 + 0.1122 + 0.03));
  const JointVector right = Reaching(Down(0.5, 0.06, 0.22 + 0.1122 + 0.03));
  const Transform below{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.1122 + 0.0255, 1};
  EXPECT_TRUE(PlanOf(planner_.ToConfiguration(left, right, 1)));
  world_.Attach("box", below);
  const PlanFailure failure = FailureOf(planner_.ToConfiguration(left, right, 1));
  EXPECT_EQ(failure.reason, PlanFailureReason::kStartInCollision);
  EXPECT_THAT(failure.text, HasSubstr("box and table overlap"));
}

TEST_F(PlannerTest, GoesAnotherWayWithSomethingInTheHand) {
  // Ends that are free with the box, on a straight way that is so without it only: over the crate.
  world_.Place("box", Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.45, 0.3, 0.245, 1});
  const JointVector left = Reaching(Down(0.57, -0.38, 0.36 + 0.1122 + 0.025));
  const JointVector right = Reaching(Down(0.57, -0.05, 0.36 + 0.1122 + 0.025));
  const auto empty = PlanOf(planner_.ToConfiguration(left, right, 1));
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->waypoints.size(), 2);
  const Transform below{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.1122 + 0.0255, 1};
  world_.Attach("box", below);
  const auto full = PlanOf(planner_.ToConfiguration(left, right, 1));
  ASSERT_TRUE(full);
  EXPECT_GT(full->waypoints.size(), 2);
  EngineView engine(Options("clutter.xml"));
  for (Duration t{}; t < full->trajectory.duration(); t += kCycle) {
    const JointVector q = full->trajectory.Sample(t).q;
    const Transform X =
        model::Multiply(model::ArmModel::Panda().Pose(model::Frame::kFlange, q), below);
    engine.Put("box", model::Orientation(X), model::Position(X));
    engine.Set(q, 0.08);
    ASSERT_THAT(engine.ContactsOf("box"), testing::IsEmpty()) << ToSeconds(t) << " s";
    ASSERT_THAT(engine.RobotContacts(), testing::IsEmpty()) << ToSeconds(t) << " s";
  }
}

TEST_F(PlannerTest, NamesWhatTheGoalIsInCollisionWith) {
  const JointVector goal = Reaching(Down(0.5, 0, 0.25));
  const PlanFailure failure = FailureOf(planner_.ToConfiguration(kReady, goal, 1));
  EXPECT_EQ(failure.reason, PlanFailureReason::kGoalInCollision);
  EXPECT_THAT(failure.text, HasSubstr("planning: the goal is in collision: "));
  EXPECT_THAT(failure.text, HasSubstr("and table overlap"));
  EXPECT_THAT(failure.text, HasSubstr("and box overlap"));
}

TEST_F(PlannerTest, NamesWhatTheStartIsTooNearTo) {
  const JointVector start = Reaching(Down(0.5, -0.1, 0.22 + 0.1122 + 0.004));
  const PlanFailure failure = FailureOf(planner_.ToConfiguration(start, kReady, 1));
  EXPECT_EQ(failure.reason, PlanFailureReason::kStartInCollision);
  EXPECT_THAT(failure.text, HasSubstr("table are 4.0 mm apart"));
  EXPECT_THAT(failure.text, HasSubstr("clearance of 10.0 mm"));
}

TEST_F(PlannerTest, ReachesAPoseByTheNearestWay) {
  const Transform O_T_F = Down(0.45, 0.15, 0.5);
  EngineView engine(Options("clutter.xml"));
  const auto plan = PlanOf(planner_.ToPose(kReady, O_T_F, 1));
  ASSERT_TRUE(plan);
  const Transform reached =
      model::ArmModel::Panda().Pose(model::Frame::kFlange, plan->trajectory.goal());
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(reached[i], O_T_F[i], 1e-9);
  EXPECT_EQ(FirstContact(engine, plan->trajectory, 0.08), std::nullopt);
}

TEST_F(PlannerTest, TellsWhyAPoseCannotBeReached) {
  const PlanFailure far = FailureOf(planner_.ToPose(kReady, Down(0.9, 0, 0.5), 1));
  EXPECT_EQ(far.reason, PlanFailureReason::kGoalUnreachable);
  EXPECT_THAT(far.text, HasSubstr("out of the arm's reach"));
  const PlanFailure low = FailureOf(planner_.ToPose(kReady, Down(0.55, 0.1, 0.25), 1));
  EXPECT_EQ(low.reason, PlanFailureReason::kGoalInCollision);
  EXPECT_THAT(low.text, HasSubstr("and table overlap"));
}

TEST_F(PlannerTest, GivesUpWhenTheBudgetIsUsedUp) {
  PlannerOptions options;
  options.most_checks = 300;
  Planner planner(world_, limits_, clock_, options);
  const Problem problem = ProblemOf(world_, 0);
  const PlanFailure failure = FailureOf(planner.ToConfiguration(problem.start, problem.goal, 1));
  EXPECT_EQ(failure.reason, PlanFailureReason::kBudgetExhausted);
  EXPECT_THAT(failure.text, HasSubstr("within 300 collision checks"));
  EXPECT_GE(failure.statistics.checks, 300);
  EXPECT_LE(failure.statistics.checks, 302);
}

/// A ring of four bars round the forearm of the ready pose, too narrow for the hand to leave it.
std::string RingRoundTheForearm() {
  CollisionWorld world(Options("floor.xml"));
  static_cast<void>(world.IsFree(kReady));
  const Transform X = world.PoseOf("panda_link5");
  const auto bar = [](const char* name, double x, double y, double half_x, double half_y) {
    return fmt::format(R"(<geom name="{}" type="box" pos="{} {} -0.21" size="{} {} 0.01"/>)", name,
                       x, y, half_x, half_y);
  };
  return fmt::format(
      R"(<mujoco><worldbody><body name="ring" pos="{} {} {}" xyaxes="{} {} {} {} {} {}">{}{}{}{}</body></worldbody></mujoco>)",
      X[12], X[13], X[14], X[0], X[1], X[2], X[4], X[5], X[6], bar("a", 0.09, 0, 0.01, 0.1),
      bar("b", -0.09, 0, 0.01, 0.1), bar("c", 0, 0.09, 0.1, 0.01), bar("d", 0, -0.09, 0.1, 0.01));
}

TEST_F(PlannerTest, GivesUpOnAGoalThatIsWalledIn) {
  const test::TemporaryFolder folder;
  plant::MujocoPlantOptions scene = Options("floor.xml");
  scene.scene = folder.path() / "ring.xml";
  std::ofstream(scene.scene) << RingRoundTheForearm();
  CollisionWorld walled(scene);
  CollisionWorld open(Options("floor.xml"));
  ASSERT_TRUE(walled.IsFree(kReady, 0.01)) << Describe(walled.Touches(kReady, 0.01));
  const JointVector away{1, 1, 0, -1, 0, 2, 0.8};
  PlannerOptions options;
  options.most_checks = 5000;
  const PlanFailure failure =
      FailureOf(Planner(walled, limits_, clock_, options).ToConfiguration(away, kReady, 1));
  EXPECT_EQ(failure.reason, PlanFailureReason::kBudgetExhausted);
  EXPECT_THAT(failure.text, HasSubstr("within 5000 collision checks"));
  EXPECT_TRUE(PlanOf(Planner(open, limits_, clock_, options).ToConfiguration(away, kReady, 1)));
}

TEST_F(PlannerTest, StatisticsCountChecksAndTheTimeOfTheClockGiven) {
  const std::uint64_t before = world_.checks();
  const auto plan = PlanOf(planner_.ToConfiguration(kReady, Reaching(Down(0.4, 0, 0.6)), 1));
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->statistics.checks, world_.checks() - before);
  EXPECT_EQ(plan->statistics.wall, kCycle);
  EXPECT_EQ(plan->statistics.waypoints, plan->waypoints.size());
}

TEST_F(PlannerTest, RefusesBadQuestions) {
  JointVector outside = kReady;
  outside[3] = 0;
  EXPECT_THAT(MessageOf<InputError>(
                  [&] { static_cast<void>(planner_.ToConfiguration(kReady, outside, 1)); }),
              HasSubstr("joint 4 of the goal"));
  EXPECT_THAT(MessageOf<InputError>(
                  [&] { static_cast<void>(planner_.ToConfiguration(outside, kReady, 1)); }),
              HasSubstr("joint 4 of the start"));
  EXPECT_THAT(MessageOf<InputError>(
                  [&] { static_cast<void>(planner_.ToConfiguration(kReady, kReady, 1)); }),
              HasSubstr("coincide"));
  PlannerOptions options;
  options.clearance = 0;
  EXPECT_THAT(MessageOf<InputError>([&] { Planner(world_, limits_, clock_, options); }),
              HasSubstr("planning: clearance"));
}

}  // namespace
}  // namespace twin::planning::planning_planner_test
