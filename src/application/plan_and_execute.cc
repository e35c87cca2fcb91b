#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "application/applications.h"
#include "twin/core/random.h"
#include "twin/planning/planner.h"
#include "twin/planning/random_goal.h"

namespace twin::application {
namespace {

/// The first goal has the scenario's seed, so a planned motion with this seed has the same goal.
std::uint64_t SeedOfGoal(std::uint64_t scenario, int goal) {
  if (goal == 1) return scenario;
  const auto bits =
      Random(scenario, RandomStream::kGoalSeed).Bits(static_cast<std::uint64_t>(goal));
  return std::uint64_t{bits[0]} << 32 | bits[1];
}

class PlanAndExecute final : public Application {
 public:
  explicit PlanAndExecute(control::ParameterReader& parameters)
      : goals_(static_cast<int>(parameters.Number("goals", 1, 1, 100))),
        clearance_(parameters.Quantity("clearance", Dimension::kLength, 0.015, 0.001, 0.1)),
        budget_(static_cast<std::uint64_t>(parameters.Number("budget", 100'000, 1, 1e9))),
        controller_(parameters.Below("controller")) {}

  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    return goals_ * std::chrono::seconds(30);
  }
  void Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override;

 private:
  StepEnd Plan(Stage& stage, planning::CollisionWorld& world, int goal);
  StepEnd Execute(Stage& stage);
  void CheckDensely(planning::CollisionWorld& world, const reference::Trajectory& trajectory);

  const int goals_;
  const double clearance_;
  const std::uint64_t budget_;
  const control::Parameters controller_;

  std::optional<planning::Plan> plan_;  ///< of the next motion
  std::uint64_t most_checks_ = 0;       ///< of one plan
  std::uint64_t dense_ = 0;             ///< configurations of the plans, checked again
  std::uint64_t touching_ = 0;          ///< those in collision
  double final_error_ = 0;              ///< largest over the motions, rad
};

void PlanAndExecute::Perform(Stage& stage) {
  const auto world = stage.MakeWorld();
  std::vector<TaskStep> steps;
  for (int goal = 1; goal <= goals_; ++goal) {
    const std::string number = goals_ == 1 ? "" : fmt::format(" {}", goal);
    steps.push_back(
        {.name = "plan" + number, .act = [&, goal] { return Plan(stage, *world, goal); }});
    steps.push_back({.name = "execute" + number, .act = [&] { return Execute(stage); }});
  }
  stage.Carry(steps);
}

StepEnd PlanAndExecute::Plan(Stage& stage, planning::CollisionWorld& world, int goal) {
  const JointLimits& limits = stage.session.robot().limits;
  const Time begun = stage.session.Now();
  const JointVector start = stage.session.ReadState().q;
  const std::uint64_t seed = SeedOfGoal(stage.scenario.seed, goal);
  const JointVector q_goal =
      planning::RandomGoal(world, limits, seed, {.from = start, .clearance = clearance_});
  planning::Planner planner(world, limits, stage.clock,
                            {.most_checks = budget_, .clearance = clearance_});
  planning::PlanOutcome outcome = planner.ToConfiguration(start, q_goal, seed);
  if (const auto* failure = std::get_if<planning::PlanFailure>(&outcome)) {
    return {false, failure->text};
  }
  plan_.emplace(std::move(std::get<planning::Plan>(outcome)));
  CheckDensely(world, plan_->trajectory);
  most_checks_ = std::max(most_checks_, plan_->statistics.checks);
  stage.result.planning_time += plan_->statistics.wall;
  stage.result.plans.push_back(
      {.id = fmt::format("goal_{}", goal),
       .caption = fmt::format("Around what stands there to goal {} of {}", goal, goals_),
       .from = begun,
       .until = begun,
       .q = q_goal,
       .path = EndEffectorPath(plan_->trajectory, stage.F_T_EE())});
  return {true, fmt::format("{:.2f} s through {} points, {} collision checks",
                            ToSeconds(plan_->trajectory.duration()), plan_->statistics.waypoints,
                            plan_->statistics.checks)};
}

void PlanAndExecute::CheckDensely(planning::CollisionWorld& world,
                                  const reference::Trajectory& trajectory) {
  for (Duration t{}; t <= trajectory.duration(); t += kCycle) {
    ++dense_;
    touching_ += world.Touches(trajectory.Sample(t).q).empty() ? 0 : 1;
  }
}

StepEnd PlanAndExecute::Execute(Stage& stage) {
  record::PlanRecord& plan = stage.result.plans.back();
  run::Motion motion =
      run::MotionOn(stage.scenario, plan.id, control::CommandInterface::kTorque, plan_->trajectory);
  motion.controller.parameters = controller_;
  const run::MotionResult result = stage.Move(motion);
  plan.until = stage.session.Now();
  final_error_ = std::max(final_error_, result.final_error);
  return {result.report.succeeded(), result.report.failure};
}

Evaluation PlanAndExecute::Evaluate(const TaskResult& task_result, const Evidence& evidence) {
  Evaluation evaluation;
  const auto count = [](std::uint64_t number) { return static_cast<double>(number); };
  evaluation.Add("plans", count(task_result.plans.size()));
  evaluation.Demand("collision checks of a plan, largest", count(most_checks_), "",
                    fmt::format("at most {}", budget_), most_checks_ <= budget_);
  evaluation.Add("configurations of the plans checked again, every millisecond", count(dense_));
  evaluation.DemandAtMost("configurations in collision", count(touching_), "", 0);
  if (evidence.contacts != nullptr) {
    evaluation.DemandAtMost("cycles with contact of the arm", count(evidence.contacts->cycles()),
                            "", 0);
  }
  double deviation = 0;
  for (const run::FollowedMotion& motion : evidence.session.followed) {
    if (motion.deviation.joints) deviation = std::max(deviation, motion.deviation.joints->largest);
  }
  evaluation.Add("largest distance of a joint from the plan (delay included)", deviation * 1e3,
                 "mrad");
  evaluation.findings.back().demand = "within the controller's path tolerance, else the step fails";
  evaluation.Add("joint position error at the goal, largest", final_error_ * 1e3, "mrad");
  evaluation.findings.back().demand = "within the controller's goal tolerance, else the step fails";
  return evaluation;
}

}  // namespace

std::unique_ptr<Application> MakePlanAndExecute(control::ParameterReader& parameters) {
  return std::make_unique<PlanAndExecute>(parameters);
}

}  // namespace twin::application
