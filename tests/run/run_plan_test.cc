// Motions that a scenario leaves to the planner: planned, executed by torques, and refused.
#include <chrono>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/plan_execution.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::run::run_plan_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// The controller's own goal_tolerance.
constexpr double kGoalTolerance = 0.02;

class PlanRunTest : public ::testing::Test {
 protected:
  /// What preparing a run of it throws.
  template <typename E>
  [[nodiscard]] std::string Refusal(const scenario::Scenario& scenario) const {
    try {
      const run::Run run(scenario, problems_.catalogue(), problems_.files(), nullptr);
    } catch (const E& error) {
      return error.what();
    }
    return "(accepted)";
  }

  test::Problems problems_;
};

TEST_F(PlanRunTest, PlansAndExecutesWithoutTouchingAnything) {
  constexpr std::uint64_t kProblems = 10;
  for (std::uint64_t n = 0; n < kProblems; ++n) {
    SCOPED_TRACE(n);
    const test::Outcome outcome = problems_.Execute(problems_.Problem(n));
    ASSERT_TRUE(outcome.is_solved) << outcome.unsolved;
    EXPECT_TRUE(outcome.result.report.succeeded()) << outcome.result.report.failure;
    EXPECT_EQ(outcome.touched, 0u) << outcome.touch;
    EXPECT_GT(outcome.looks, 500u);
    EXPECT_LT(outcome.result.final_error, kGoalTolerance);
    ASSERT_TRUE(outcome.result.plan.has_value());
    EXPECT_LE(outcome.result.plan->checks, 100'000u);
  }
}

TEST_F(PlanRunTest, RepeatsToTheBit) {
  const test::Outcome first = problems_.Execute(problems_.Problem(0));
  const test::Outcome second = problems_.Execute(problems_.Problem(0));
  EXPECT_EQ(first.result.states_hash, second.result.states_hash);
  EXPECT_EQ(first.result.plan->checks, second.result.plan->checks);
}

TEST_F(PlanRunTest, KeepsTheGoalOfASeedOfItsOwn) {
  scenario::Scenario scenario = problems_.scenario();
  scenario.motion.plan->seed = 5;
  const auto goal = [this](const scenario::Scenario& s) {
    return run::Run(s, problems_.catalogue(), problems_.files(), nullptr).trajectory().goal();
  };
  const JointVector first = goal(scenario);
  scenario.seed = 77;
  EXPECT_EQ(goal(scenario), first);
  scenario.motion.plan->seed = 6;
  EXPECT_NE(goal(scenario), first);
}

TEST_F(PlanRunTest, ReachesAPoseOfTheEndEffector) {
  scenario::Scenario scenario = problems_.scenario();
  scenario.onboard.NE_T_EE.position = {0, 0, 0.05};
  const scenario::FramePose wanted{.position = {0.45, 0.3, 0.5}, .rpy = {3.0, 0.1, 0.4}};
  scenario.motion.plan->goal = wanted;
  const run::Run run(scenario, problems_.catalogue(), problems_.files(), nullptr);
  const Transform F_T_EE = model::Multiply(run.robot().F_T_NE, scenario.onboard.NE_T_EE.Matrix());
  const Transform reached =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, run.trajectory().goal(), F_T_EE);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(reached[i], wanted.Matrix()[i], 1e-6) << i;
}

TEST_F(PlanRunTest, StretchesWhatItPlans) {
  scenario::Scenario scenario = problems_.scenario();
  const auto planned = [this, &scenario] {
    return run::Run(scenario, problems_.catalogue(), problems_.files(), nullptr).trajectory();
  };
  const reference::Trajectory quick = planned();
  scenario.motion.plan->stretch = 2;
  const reference::Trajectory slow = planned();
  EXPECT_NEAR(ToSeconds(slow.duration()), 2 * ToSeconds(quick.duration()), 1e-6);
  const Duration t = quick.duration() / 3;
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(slow.Sample(2 * t).q[i], quick.Sample(t).q[i], 1e-6);
  }
}

TEST_F(PlanRunTest, NamesWhatTheGoalTouches) {
  scenario::Scenario scenario = problems_.scenario();
  // The flange 5 cm above the middle of the table: the hand is in it.
  scenario.motion.plan->goal =
      scenario::FramePose{.position = {0.6, 0, 0.18}, .rpy = {3.14159, 0, 0}};
  EXPECT_THAT(Refusal<InputError>(scenario),
              AllOf(HasSubstr("plan_and_execute.yaml:"), HasSubstr("goal"), HasSubstr("table")));
}

TEST_F(PlanRunTest, NamesWhatTheStartTouches) {
  scenario::Scenario scenario = problems_.scenario();
  scenario.robot.q_start = JointVector{0, 0.6, 0, -2.0, 0, 2.6, 0.7854};  // down, into the table
  EXPECT_THAT(Refusal<InputError>(scenario), AllOf(HasSubstr("start"), HasSubstr("table")));
}

TEST_F(PlanRunTest, TellsAGoalOutOfReach) {
  scenario::Scenario scenario = problems_.scenario();
  scenario.motion.plan->goal = scenario::FramePose{.position = {1.5, 0, 0.5}, .rpy = {3.1, 0, 0}};
  EXPECT_THAT(Refusal<InputError>(scenario), HasSubstr("goal"));
}

TEST_F(PlanRunTest, TellsWhenTheBudgetIsSpent) {
  scenario::Scenario scenario = problems_.scenario();
  scenario.motion.plan->budget = 20;
  EXPECT_THAT(Refusal<NoPlanError>(scenario),
              AllOf(HasSubstr("plan_and_execute.yaml:"), HasSubstr("within 20 collision checks")));
}

TEST_F(PlanRunTest, HasNoTrajectoryBeforeItIsPlanned) {
  const scenario::RobotData robot =
      scenario::LoadRobotData(problems_.files().models, "panda", plant::HandKind::kFrankaHand);
  EXPECT_THROW((void)MakeTrajectory(problems_.scenario(), robot), InputError);
}

}  // namespace
}  // namespace twin::run::run_plan_test
