#include "twin/application/application_run.h"

#include <chrono>
#include <utility>

#include "twin/application/stage.h"
#include "twin/core/error.h"

namespace twin::application {
namespace {

const scenario::Scenario& WithApplication(const scenario::Scenario& scenario) {
  scenario.Validate();
  if (!scenario.application) {
    throw InputError("application: the scenario has a motion, and no application");
  }
  return scenario;
}

}  // namespace

ApplicationRun::ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                               const run::RunFiles& files, rt::RecordSink* sink, const Clock& clock,
                               const run::RealtimeSettings& settings)
    : scenario_(WithApplication(scenario)),
      files_(files),
      clock_(clock),
      devices_(catalogue.devices),
      application_(Make(scenario_)),
      session_(scenario_, catalogue, files_, sink, settings) {}

const backend::Connection& ApplicationRun::connection() const noexcept {
  return session_.connection();
}

const scenario::RobotData& ApplicationRun::robot() const noexcept {
  return session_.robot();
}

Duration ApplicationRun::longest() const {
  return application_->longest(scenario_);
}

bool ApplicationRun::CheckStart(const run::TellCheck& tell) {
  const reference::Trajectory standing =
      run::StandingFor(scenario_.robot.q_start.value(), std::chrono::seconds(1), robot().limits);
  return session_.CheckStart(
      run::MotionOn(scenario_, "start", application_->first_interface(), standing), tell);
}

const TaskResult& ApplicationRun::Execute(const run::RunHooks& hooks,
                                          const std::function<void(std::string_view)>& tell) {
  session_.Begin(hooks);
  try {
    Stage stage(session_, scenario_, files_, clock_, tell, devices_);
    task_result_ = application_->Perform(stage);
  } catch (...) {
    result_ = session_.End();
    throw;
  }
  result_ = session_.End();
  return task_result_;
}

Evaluation ApplicationRun::Evaluate(Evidence evidence) {
  evidence.session = result_;
  return application_->Evaluate(task_result_, evidence);
}

}  // namespace twin::application
