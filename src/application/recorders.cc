#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "application/results.h"
#include "application/run_recorder.h"
#include "twin/render/image.h"
#include "twin/render/renderer.h"
#include "twin/replay/plan_pictures.h"

// What differs between the recorders of a motion and of an application.
namespace twin::application {
namespace {

static_assert(render::Ghost::kMostPoints <= record::PlanRecord::kMostPoints);

render::FilmSettings WithoutOverlays(render::FilmSettings settings) {
  settings.overlays = {.text = false};
  return settings;
}

class MotionRecorder final : public RunRecorder {
 public:
  using RunRecorder::RunRecorder;

 private:
  Connected Connect(const run::RealtimeSettings& settings) override {
    run_.emplace(scenario(), inputs_.catalogue, inputs_.files, page_.sink(), settings);
    if (const auto planning = run_->planning_time()) times_.planning_s = ToSeconds(*planning);
    // The reference generator settles behind the plan: the video shows that second too.
    constexpr Duration kSettling = std::chrono::seconds(1);
    return {.connection = &run_->connection(),
            .robot = &run_->robot(),
            .check_start = [this](const run::TellCheck& tell) { return run_->CheckStart(tell); },
            .longest = run_->trajectory().duration() + kSettling};
  }
  Outcome Perform(const run::RunHooks& hooks) override;
  std::string SummaryOfFile() const override {
    return run::SummaryJson(scenario(), result_, is_interrupted(), records_.contacts());
  }
  std::string SummaryOfTerminal() const override {
    return run::SummaryText(scenario(), result_, is_interrupted(), times_, records_.contacts());
  }
  /// plan_initial.png, plan.png and plan_final.png of a planned motion.
  void Draw(const render::Film& film, const render::FilmSettings& settings) override {
    if (film.goals.empty()) return;
    replay::PlanPictures pictures(film, WithoutOverlays(settings));
    const render::PlannedGoal& plan = film.goals.front();
    render::WritePng(out_.plan_initial(), pictures.Before(plan));
    render::WritePng(out_.plan(), pictures.Planned(plan));
    render::WritePng(out_.plan_final(), pictures.Done(plan));
  }

  std::optional<run::Run> run_;
  run::RunResult result_;
};

RunRecorder::Outcome MotionRecorder::Perform(const run::RunHooks& hooks) {
  const Time begin = clock_.Now();
  run::RunHooks shown = hooks;
  shown.progress = [&](Time now, Duration planned) {
    hooks.progress(now, planned);
    const double simulated = ToSeconds(now.time_since_epoch());
    inputs_.console.Show("run", simulated / ToSeconds(planned),
                         fmt::format("{:.1f} of {:.1f} s, {:.1f} x real time", simulated,
                                     ToSeconds(planned), simulated / SecondsSince(begin)));
  };
  result_ = run_->Execute(shown);
  const loop::RunReport& report = result_.report;
  Outcome outcome{.simulated = report.simulated,
                  .followed = {result_.followed},
                  .notices = report.notices,
                  .robot = report.robot_timings};
  if (run_->planning_time()) {
    const Transform F_T_EE = run_->robot().F_T_EE(scenario().onboard.NE_T_EE);
    outcome.plans = {{.id = "plan",
                      .caption = "Around what stands there to the goal",
                      .until = Time(report.simulated),
                      .q = run_->trajectory().goal(),
                      .path = EndEffectorPath(run_->trajectory(), F_T_EE)}};
  }
  if (report.succeeded()) return outcome;
  outcome.failure = report.failure;
  for (const Violation& violation : report.violations) outcome.cause += "; " + Describe(violation);
  if (scenario().record && report.end == backend::MotionEnd::kAborted) {
    outcome.cause += fmt::format("; why: panda-twin explain {}", out_.log().string());
  }
  return outcome;
}

class ApplicationRecorder final : public RunRecorder {
 public:
  explicit ApplicationRecorder(const RunInputs& inputs)
      : RunRecorder(inputs),
        devices_(page_.Devices(inputs.catalogue)),
        catalogue_{inputs.catalogue.backends, inputs.catalogue.controllers, &devices_} {}

 private:
  Connected Connect(const run::RealtimeSettings& settings) override {
    run_.emplace(scenario(), catalogue_, inputs_.files, page_.sink(), clock_, settings);
    return {.connection = &run_->connection(),
            .robot = &run_->robot(),
            .check_start = [this](const run::TellCheck& tell) { return run_->CheckStart(tell); },
            .longest = run_->longest()};
  }
  Outcome Perform(const run::RunHooks& hooks) override;
  void Evaluate(Outcome& outcome) override;
  std::string SummaryOfFile() const override {
    return SummaryJson(scenario(), result_, records_.contacts());
  }
  std::string SummaryOfTerminal() const override {
    return SummaryText(scenario(), result_, times_);
  }
  /// Two pictures of each plan: NUMBER_ID_plan.png and NUMBER_ID.png.
  void Draw(const render::Film& film, const render::FilmSettings& settings) override;
  void WriteReport(const std::vector<std::filesystem::path>& plots) const override;

  const teleop::DeviceRegistry devices_;  ///< the page's among them
  const run::Catalogue catalogue_;
  std::optional<ApplicationRun> run_;
  ApplicationResult result_;
  std::vector<PicturePair> pictures_;
};

RunRecorder::Outcome ApplicationRecorder::Perform(const run::RunHooks& hooks) {
  result_.task_result = run_->Execute(
      hooks, [this](std::string_view line) { inputs_.console.Print(fmt::format("{}\n", line)); });
  const TaskResult& task_result = result_.task_result;
  times_.planning_s = ToSeconds(task_result.planning_time);
  result_.session = run_->result();
  result_.interrupted = is_interrupted();
  Outcome outcome{.plans = task_result.plans,
                  .followed = result_.session.followed,
                  .robot = result_.session.robot_timings};
  if (!task_result.task.steps.empty()) {
    outcome.simulated = task_result.task.steps.back().ended.time_since_epoch();
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
                      .contacts = records_.contacts() ? &*records_.contacts() : nullptr});
  outcome.failure = FailureOf(result_.task_result, result_.evaluation);
}

void ApplicationRecorder::Draw(const render::Film& film, const render::FilmSettings& settings) {
  run::MakeFolder(out_.snapshots());
  replay::PlanPictures pictures(film, WithoutOverlays(settings));
  for (std::size_t i = 0; i < result_.task_result.plans.size(); ++i) {
    const std::string name = fmt::format("{}_{}", i + 1, result_.task_result.plans[i].id);
    const PicturePair& pair = pictures_.emplace_back(
        PicturePair{out_.snapshots() / (name + "_plan.png"), out_.snapshots() / (name + ".png")});
    render::WritePng(pair.planned, pictures.Planned(film.goals[i]));
    render::WritePng(pair.done, pictures.Done(film.goals[i]));
  }
}

void ApplicationRecorder::WriteReport(const std::vector<std::filesystem::path>& plots) const {
  PageFacts facts{.pictures = pictures_, .plots = plots, .has_video = is_filmed()};
  facts.lines = {{"application", scenario().application->type},
                 {"seed", fmt::format("{}", scenario().seed)},
                 {"site", inputs_.options.site},
                 {"backend", scenario().backend},
                 {"drive", std::string(scenario().drive_name())},
                 {"motions", fmt::format("{}", result_.session.motions)},
                 {"panda-twin", TWIN_VERSION}};
  run::WriteWholeFile(out_.report(),
                      PageOf(scenario(), result_.task_result, result_.evaluation, facts));
}

}  // namespace

std::unique_ptr<RunRecorder> MakeMotionRecorder(const RunInputs& inputs) {
  return std::make_unique<MotionRecorder>(inputs);
}

std::unique_ptr<RunRecorder> MakeApplicationRecorder(const RunInputs& inputs) {
  return std::make_unique<ApplicationRecorder>(inputs);
}

}  // namespace twin::application
