#include "application/plan_and_execute.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "twin/application/end_effector_path.h"
#include "twin/application/stage.h"
#include "twin/core/random.h"
#include "twin/planning/planner.h"
#include "twin/planning/random_goal.h"

namespace twin::application {
namespace {

/// The first goal's is the scenario's, so that the same seed is the same goal as in a planned
/// motion.
std::uint64_t SeedOf(std::uint64_t scenario, int goal) {
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

  [[nodiscard]] control::CommandInterface first_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    return goals_ * std::chrono::seconds(30);
  }
  [[nodiscard]] TaskResult Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override;

 private:
  StepEnd Plan(Stage& stage, int goal);
  StepEnd Execute(Stage& stage);
  void CheckDensely(planning::CollisionWorld& world, const reference::Trajectory& trajectory);

  const int goals_;
  const double clearance_;
  const std::uint64_t budget_;
  const control::Parameters controller_;

  std::optional<planning::Plan> plan_;  ///< of the motion that comes next
  TaskResult task_result_;
  std::uint64_t checks_ = 0;       ///< of all plans
  std::uint64_t most_checks_ = 0;  ///< of one plan
  std::uint64_t dense_ = 0;        ///< configurations of the plans looked at once more
  std::uint64_t touching_ = 0;     ///< of these
  double final_error_ = 0;         ///< largest over the motions, rad
};

TaskResult PlanAndExecute::Perform(Stage& stage) {
  std::vector<TaskStep> steps;
  for (int goal = 1; goal <= goals_; ++goal) {
    const std::string number = goals_ == 1 ? "" : fmt::format(" {}", goal);
    steps.push_back(
        {.name = "plan" + number, .act = [this, &stage, goal] { return Plan(stage, goal); }});
    steps.push_back({.name = "execute" + number, .act = [this, &stage] { return Execute(stage); }});
  }
  task_result_.task = stage.Carry(steps);
  return std::move(task_result_);
}

StepEnd PlanAndExecute::Plan(Stage& stage, int goal) {
  planning::CollisionWorld& world = stage.World();
  const JointLimits& limits = stage.robot().limits;
  const Time begun = stage.session().Now();
  const JointVector start = stage.session().ReadState().q;
  const std::uint64_t seed = SeedOf(stage.scenario().seed, goal);
  const JointVector q_goal =
      planning::RandomGoal(world, limits, seed, {.from = start, .clearance = clearance_});
  planning::Planner planner(world, limits, stage.clock(),
                            {.most_checks = budget_, .clearance = clearance_});
  planning::PlanOutcome outcome = planner.ToConfiguration(start, q_goal, seed);
  if (const auto* failure = std::get_if<planning::PlanFailure>(&outcome)) {
    return {false, failure->text};
  }
  plan_.emplace(std::move(std::get<planning::Plan>(outcome)));
  CheckDensely(world, plan_->trajectory);
  checks_ += plan_->statistics.checks;
  most_checks_ = std::max(most_checks_, plan_->statistics.checks);
  task_result_.planning_time += plan_->statistics.wall;
  task_result_.snapshots.push_back(
      {.id = fmt::format("goal_{}", goal),
       .caption = fmt::format("Around what stands there to goal {} of {}", goal, goals_),
       .planned = begun,
       .done = begun,
       .goal = q_goal,
       .way = EndEffectorPath(plan_->trajectory, stage.F_T_EE())});
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
  run::Motion motion = stage.NewMotion(task_result_.snapshots.back().id,
                                       control::CommandInterface::kTorque, plan_->trajectory);
  motion.controller.parameters = controller_;
  const run::MotionResult result = stage.session().Move(motion);
  task_result_.snapshots.back().done = stage.session().Now();
  final_error_ = std::max(final_error_, result.final_error);
  return {result.report.succeeded(), result.report.failure};
}

Evaluation PlanAndExecute::Evaluate(const TaskResult& task_result, const Evidence& evidence) {
  Evaluation evaluation;
  const auto add = [&evaluation](Finding finding) {
    evaluation.findings.push_back(std::move(finding));
  };
  const auto count = [](std::uint64_t number) { return static_cast<double>(number); };
  add({.quantity = "plans", .value = count(task_result.snapshots.size())});
  add({.quantity = "collision checks of a plan, largest",
       .value = count(most_checks_),
       .demand = fmt::format("at most {}", budget_),
       .met = most_checks_ <= budget_});
  add({.quantity = "configurations of the plans checked again, every millisecond",
       .value = count(dense_)});
  add({.quantity = "configurations in collision",
       .value = count(touching_),
       .demand = "none",
       .met = touching_ == 0});
  if (evidence.contacts != nullptr) {
    add({.quantity = "cycles with contact of the arm",
         .value = count(evidence.contacts->cycles()),
         .demand = "none",
         .met = evidence.contacts->cycles() == 0});
  }
  double deviation = 0;
  for (const run::FollowedMotion& motion : evidence.session.followed) {
    if (motion.deviation.joints) deviation = std::max(deviation, motion.deviation.joints->largest);
  }
  add({.quantity = "largest distance of a joint from the plan (delay included)",
       .value = deviation * 1e3,
       .unit = "mrad",
       .demand = "within the controller's path tolerance, else the step fails"});
  add({.quantity = "joint position error at the goal, largest",
       .value = final_error_ * 1e3,
       .unit = "mrad",
       .demand = "within the controller's goal tolerance, else the step fails"});
  return evaluation;
}

}  // namespace

std::unique_ptr<Application> MakePlanAndExecute(control::ParameterReader& parameters) {
  return std::make_unique<PlanAndExecute>(parameters);
}

}  // namespace twin::application
