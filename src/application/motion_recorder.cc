#include <optional>
#include <string>

#include <fmt/format.h>

#include "application/run_recorder.h"
#include "twin/application/plan_pictures.h"

namespace twin::application {
namespace {

class MotionRecorder final : public RunRecorder {
 public:
  using RunRecorder::RunRecorder;

 private:
  Connected Connect(const run::RealtimeSettings& settings) override {
    run_.emplace(scenario(), parts_.catalogue, parts_.files, page_.sink(), settings);
    if (const auto planning = run_->planning_time()) times_.planning_s = ToSeconds(*planning);
    // The reference generator settles behind the plan: frames of that second belong to the video.
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
  std::string SummaryForPeople() const override {
    return run::SummaryText(scenario(), result_, is_interrupted(), times_, records_.contacts());
  }
  void Draw(const render::Film& film, const render::FilmSettings& settings) override {
    if (!film.goals.empty()) DrawPlannedMotion(film, settings, out_);
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
    parts_.console.Show("run", simulated / ToSeconds(planned),
                        fmt::format("{:.1f} of {:.1f} s, {:.1f} x real time", simulated,
                                    ToSeconds(planned), simulated / SecondsSince(begin)));
  };
  result_ = run_->Execute(shown);
  const loop::RunReport& report = result_.report;
  Outcome outcome{.simulated = report.simulated,
                  .followed = {result_.followed},
                  .notices = report.notices,
                  .robot = report.robot_timings};
  if (run_->planning_time()) outcome.plans = {PlanOf(*run_, scenario(), Time(report.simulated))};
  if (report.succeeded()) return outcome;
  outcome.failure = report.failure;
  for (const Violation& violation : report.violations) outcome.cause += "; " + Describe(violation);
  if (scenario().record && report.end == backend::MotionEnd::kAborted) {
    outcome.cause += fmt::format("; why: panda-twin explain {}", out_.log().string());
  }
  return outcome;
}

}  // namespace

std::unique_ptr<RunRecorder> MakeMotionRecorder(const RunParts& parts) {
  return std::make_unique<MotionRecorder>(parts);
}

}  // namespace twin::application
