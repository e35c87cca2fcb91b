#include "twin/application/stage.h"

#include <utility>

#include <fmt/format.h>

namespace twin::application {

Stage::Stage(run::Session& session, const scenario::Scenario& scenario, const run::RunFiles& files,
             const Clock& clock, std::function<void(std::string_view)> tell,
             const teleop::DeviceRegistry* devices)
    : session_(session),
      scenario_(scenario),
      files_(files),
      clock_(clock),
      tell_(std::move(tell)),
      devices_(devices),
      F_T_EE_(session.robot().F_T_EE(scenario.onboard.NE_T_EE)) {}

planning::CollisionWorld& Stage::World() {
  if (!world_) {
    world_ = std::make_unique<planning::CollisionWorld>(
        run::MakeRobotConfig(scenario_, robot(), files_).plant);
  }
  return *world_;
}

run::Motion Stage::NewMotion(std::string name, control::CommandInterface interface,
                             reference::Trajectory trajectory) const {
  return run::MotionOn(scenario_, std::move(name), interface, std::move(trajectory));
}

TaskReport Stage::Carry(const std::vector<TaskStep>& steps) const {
  const auto told = [this](const StepReport& step) {
    const std::string line =
        fmt::format("{}: {}{}{}", step.name, step.succeeded ? "done" : "failed",
                    step.text.empty() ? "" : ", ", step.text);
    session_.Tell("step", line);
    Tell(fmt::format("{:8.3f} s  {}", ToSeconds(step.ended.time_since_epoch()), line));
  };
  return application::Carry(
      steps, [this] { return session_.Now(); }, told, [this] { return session_.interrupted(); });
}

}  // namespace twin::application
