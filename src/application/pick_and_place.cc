#include <chrono>
#include <memory>

#include "application/applications.h"
#include "application/pick.h"
#include "application/pick_steps.h"

namespace twin::application {
namespace {

class PickAndPlace final : public Application {
 public:
  explicit PickAndPlace(control::ParameterReader& parameters)
      : steps_(Handling(parameters), parameters.Below("controller")), put_down_(parameters) {}

  void Require(const scenario::Scenario& scenario) const override {
    static_cast<void>(TaskOf(scenario));
    RequireFingers(scenario);
  }
  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    return std::chrono::seconds(120);
  }
  void Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override {
    return EvaluatePick(steps_.record(), task_result, evidence);
  }

 private:
  [[nodiscard]] PickTask TaskOf(const scenario::Scenario& scenario) const {
    PickTask task = ObjectOf(scenario, steps_.handling());
    AddGoal(scenario, put_down_, task);
    return task;
  }

  PickSteps steps_;
  const PutDown put_down_;
};

void PickAndPlace::Perform(Stage& stage) {
  steps_.Begin(stage, TaskOf(stage.scenario));
  const int tries = steps_.handling().tries;
  stage.Carry({StepOf(steps_, "plan", &PickSteps::Plan),
               StepOf(steps_, "approach", &PickSteps::Approach, "approach", 2),
               StepOf(steps_, "grasp", &PickSteps::Grasp, "approach", tries),
               StepOf(steps_, "lift", &PickSteps::Lift, "approach", 2),
               StepOf(steps_, "transfer", &PickSteps::Transfer, "transfer", 2),
               StepOf(steps_, "place", &PickSteps::Place, "place", 2),
               StepOf(steps_, "release", &PickSteps::Release),
               StepOf(steps_, "retreat", &PickSteps::Retreat, "retreat", 2)});
}

}  // namespace

std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters) {
  return std::make_unique<PickAndPlace>(parameters);
}

}  // namespace twin::application
