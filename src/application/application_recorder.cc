#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "application/run_recorder.h"
#include "twin/application/application_run.h"
#include "twin/application/page.h"
#include "twin/application/plan_pictures.h"
#include "twin/application/summary.h"

namespace twin::application {
namespace {

class ApplicationRecorder final : public RunRecorder {
 public:
  explicit ApplicationRecorder(const RunParts& parts)
      : RunRecorder(parts),
        devices_(page_.Devices(parts.catalogue)),
        catalogue_{parts.catalogue.backends, parts.catalogue.controllers, &devices_} {}

 private:
  Connected Connect(const run::RealtimeSettings& settings) override {
    run_.emplace(scenario(), catalogue_, parts_.files, page_.sink(), clock_, settings);
    return {.connection = &run_->connection(),
            .robot = &run_->robot(),
            .check_start = [this](const run::TellCheck& tell) { return run_->CheckStart(tell); },
            .longest = run_->longest(),
            .evaluates_scenes = true};
  }
  Outcome Perform(const run::RunHooks& hooks) override;
  void Evaluate(Outcome& outcome) override;
  std::string SummaryOfFile() const override {
    return SummaryJson(scenario(), result_, records_.contacts());
  }
  std::string SummaryForPeople() const override { return SummaryText(scenario(), result_, times_); }
  void Draw(const render::Film& film, const render::FilmSettings& settings) override {
    snapshots_ = DrawSnapshots(film, result_.task_result.snapshots, settings, out_.snapshots());
  }
  void Report(const std::vector<std::filesystem::path>& plots) const override;

  const teleop::DeviceRegistry devices_;  ///< of page_, too
  const run::Catalogue catalogue_;
  std::optional<ApplicationRun> run_;
  ApplicationResult result_;
  std::vector<SnapshotPictures> snapshots_;
};

RunRecorder::Outcome ApplicationRecorder::Perform(const run::RunHooks& hooks) {
  result_.task_result = run_->Execute(
      hooks, [this](std::string_view line) { parts_.console.Print(fmt::format("{}\n", line)); });
  times_.planning_s = ToSeconds(result_.task_result.planning_time);
  result_.session = run_->result();
  result_.interrupted = is_interrupted();
  Outcome outcome{.followed = result_.session.followed, .robot = result_.session.robot_timings};
  if (!result_.task_result.task.steps.empty()) {
    outcome.simulated = result_.task_result.task.steps.back().ended.time_since_epoch();
  }
  for (const Snapshot& snapshot : result_.task_result.snapshots) {
    outcome.plans.push_back(PlanOf(snapshot));
  }
  return outcome;
}

void ApplicationRecorder::Evaluate(Outcome& outcome) {
  if (result_.interrupted) {
    outcome.failure = "it was broken off";
    return;
  }
  result_.evaluation =
      run_->Evaluate({.log = scenario().record ? out_.log() : std::filesystem::path(),
                      .truth = run_->connection().truth,
                      .contacts = records_.contacts() ? &*records_.contacts() : nullptr,
                      .snapshots = records_.snapshots()});
  if (Succeeded(result_.task_result, result_.evaluation)) return;
  outcome.failure = FailureOf(result_.task_result, result_.evaluation);
}

void ApplicationRecorder::Report(const std::vector<std::filesystem::path>& plots) const {
  PageFacts facts{.snapshots = snapshots_, .plots = plots, .has_video = is_filmed()};
  facts.lines = {{"application", scenario().application->type},
                 {"seed", fmt::format("{}", scenario().seed)},
                 {"site", parts_.options.site},
                 {"backend", scenario().backend},
                 {"drive", std::string(scenario().drive_name())},
                 {"motions", fmt::format("{}", result_.session.motions)},
                 {"panda-twin", TWIN_VERSION}};
  run::WriteWholeFile(out_.report(),
                      PageOf(scenario(), result_.task_result, result_.evaluation, facts));
}

}  // namespace

std::unique_ptr<RunRecorder> MakeApplicationRecorder(const RunParts& parts) {
  return std::make_unique<ApplicationRecorder>(parts);
}

}  // namespace twin::application
