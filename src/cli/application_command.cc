#include "cli/application_command.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/application_summary.h"
#include "cli/interrupt.h"
#include "cli/picture.h"
#include "cli/plan_records.h"
#include "cli/remote_run.h"
#include "cli/result_folder.h"
#include "cli/run_page.h"
#include "cli/run_records.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "cli/snapshot_pictures.h"
#include "cli/summary.h"
#include "twin/application/application_run.h"
#include "twin/application/page.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/report/plots.h"

namespace twin::cli {
namespace {

scenario::Scenario WithoutSpeed(const scenario::Scenario& scenario, const RunFlags& flags) {
  if (flags.max_speed) {
    throw InputError(
        "--max-speed goes with a motion; an application makes its own: see its parameters");
  }
  return scenario;
}

/// One run of an application, from its flags to its results.
class ApplicationSession {
 public:
  ApplicationSession(const scenario::Scenario& scenario, const RunFlags& flags, const Host& host,
                     const run::Catalogue& catalogue, std::optional<fci::Capture>& capture)
      : flags_(flags),
        scenario_(WithoutSpeed(scenario, flags)),
        settings_(SettingsOf(flags)),
        out_(OutOf(scenario_, flags)),
        page_(flags, records_, interrupt_, out_.folder()),
        devices_(page_.Devices(catalogue)),
        catalogue_{catalogue.backends, catalogue.controllers, &devices_} {
    RequirePrograms(scenario_, wants_video(), host);
    Connect(
        scenario_, flags, wants_video(), settings_, capture, [&]() -> const auto& {
          run_.emplace(scenario_, catalogue_, FilesOf(flags, host), page_.sink(), clock_,
                       settings_);
          return run_->connection();
        });
    TellIfWithoutMeshes(scenario_, run_->connection());
    if (makes_video()) CheckPicture(run_->connection(), scenario_.render, flags.scenario);
    out_.Prepare();
    times_.prepare_s = SecondsSince(Time());
  }

  ExitCode Execute();
  /// Whether the folder of results holds this run's summary.
  [[nodiscard]] bool has_summary() const noexcept { return has_summary_; }

 private:
  void Perform();
  void Evaluate();
  [[nodiscard]] std::string HowItEnded() const;
  void WriteResults();
  void MakePictures();
  [[nodiscard]] application::PageFacts FactsOf() const;
  [[nodiscard]] bool wants_video() const { return scenario_.render.enabled && !flags_.no_video; }
  [[nodiscard]] bool makes_video() const {
    return wants_video() && run_->connection().truth != nullptr;
  }
  [[nodiscard]] bool is_filmed() const { return makes_video() && records_.was_filmed(); }
  [[nodiscard]] bool is_simulated() const { return scenario_.drive != scenario::Drive::kRemote; }
  [[nodiscard]] double SecondsSince(Time begin) const { return ToSeconds(clock_.Now() - begin); }

  const MonotonicClock clock_;
  const RunFlags& flags_;
  const scenario::Scenario scenario_;
  run::RealtimeSettings settings_;  ///< not changed after the constructor
  ResultFolder out_;
  const InterruptGuard interrupt_;
  WallTimes times_;
  RunRecords records_;
  RunPage page_;
  const teleop::DeviceRegistry devices_;  ///< of page_, too
  const run::Catalogue catalogue_;
  std::optional<application::ApplicationRun> run_;
  ApplicationResult result_;
  bool has_summary_ = false;
  std::vector<application::SnapshotPictures> snapshots_;
  std::vector<std::filesystem::path> plots_;
};

ExitCode ApplicationSession::Execute() {
  interrupt_.ThrowIfInterrupted();
  if (!is_simulated()) {
    RequireReady([this](const run::TellCheck& tell) { return run_->CheckStart(tell); });
  }
  interrupt_.ThrowIfInterrupted();
  const RunPage::Opening opening = page_.Open(scenario_, run_->robot(), run_->connection());
  out_.Clear();
  CarryOut(records_, out_, interrupt_, [this] {
    Perform();
    Evaluate();
    page_.Close(HowItEnded());
    WriteResults();
  });
  if (!flags_.quiet) {
    Say(stdout, fmt::format("{}  {:<13}{}\n", SummaryText(scenario_, result_, times_), "files",
                            out_.folder().string()));
  }
  if (result_.interrupted) throw Interrupted();
  if (application::Succeeded(result_.task_result, result_.evaluation)) {
    EvaluateDeviations(result_.session.followed, flags_.strict);
    return kOk;
  }
  throw RobotFault(application::FailureOf(result_.task_result, result_.evaluation));
}

void ApplicationSession::Perform() {
  BeginLog(records_, out_.log(), scenario_, run_->robot(), settings_);
  const plant::TruthProbe* truth = run_->connection().truth;
  // Logs are the same with a video and without.
  if (makes_video() || (truth != nullptr && RunRecords::CanFilm(*truth))) {
    records_.Film(*truth, run_->longest(), scenario_.render.fps);
  }
  if (truth != nullptr) records_.WatchContacts(*truth);
  run::RunHooks hooks;
  hooks.interrupted = interrupt_.flag();
  hooks.event = page_.Also(records_.Events());
  const Time begin = clock_.Now();
  result_.task_result = run_->Execute(hooks, [this](std::string_view line) {
    if (flags_.quiet) return;
    Say(stdout, fmt::format("{}\n", line));
    std::fflush(stdout);
  });
  times_.run_s = SecondsSince(begin);
  times_.planning_s = ToSeconds(result_.task_result.planning_time);
  for (const application::Snapshot& snapshot : result_.task_result.snapshots)
    records_.Add(PlanOf(snapshot));
  times_.records_dropped = records_.Finish();
  result_.session = run_->result();
  result_.interrupted = interrupt_.interrupted();
  if (!result_.task_result.task.steps.empty()) {
    const Time end = result_.task_result.task.steps.back().ended;
    times_.real_time_factor = ToSeconds(end.time_since_epoch()) / times_.run_s;
  }
  TellNotices({}, result_.session.robot_timings.notices);
}

std::string ApplicationSession::HowItEnded() const {
  if (result_.interrupted) return "it was broken off";
  if (application::Succeeded(result_.task_result, result_.evaluation)) return "it went well";
  return application::FailureOf(result_.task_result, result_.evaluation);
}

void ApplicationSession::Evaluate() {
  if (result_.interrupted) return;
  result_.evaluation =
      run_->Evaluate({.log = scenario_.record ? out_.log() : std::filesystem::path(),
                      .truth = run_->connection().truth,
                      .contacts = records_.contacts() ? &*records_.contacts() : nullptr,
                      .snapshots = records_.snapshots()});
}

void ApplicationSession::WriteResults() {
  WriteWholeFile(out_.scenario(), scenario::ToYaml(scenario_));
  WriteWholeFile(out_.summary(), SummaryJson(scenario_, result_, records_.contacts()));
  has_summary_ = true;
  if (!result_.interrupted) {
    const Time begin = clock_.Now();
    if (scenario_.record) {
      if (!flags_.quiet) Say(stdout, "plots ...\n");
      plots_ = report::WritePlots(out_.log(), run_->robot().limits, out_.plots());
    }
    times_.plots_s = SecondsSince(begin);
    if (is_filmed()) MakePictures();
    WriteWholeFile(out_.report(), application::PageOf(scenario_, result_.task_result,
                                                      result_.evaluation, FactsOf()));
  }
  times_.peak_memory_mb = PeakMemoryMb();
  WriteWholeFile(out_.timing(), TimingJson(times_, result_.session.robot_timings));
}

void ApplicationSession::MakePictures() {
  const render::Film film = records_.FilmOf(scenario_);
  const render::FilmSettings settings = FilmOf(scenario_.render);
  times_.video_s = ShowClip(render::FramesOf(film, settings), {out_.video(), out_.contact_sheet()},
                            interrupt_, clock_, flags_.quiet)
                       .seconds;
  snapshots_ = DrawSnapshots(film, result_.task_result.snapshots, settings, out_.snapshots());
}

application::PageFacts ApplicationSession::FactsOf() const {
  application::PageFacts facts{.snapshots = snapshots_, .plots = plots_, .has_video = is_filmed()};
  facts.lines = {{"application", scenario_.application->type},
                 {"seed", fmt::format("{}", scenario_.seed)},
                 {"site", flags_.lab ? "lab " + *flags_.lab : "the scenario's own"},
                 {"backend", scenario_.backend},
                 {"drive", std::string(Name(scenario_.drive))},
                 {"motions", fmt::format("{}", result_.session.motions)},
                 {"panda-twin", TWIN_VERSION}};
  return facts;
}

}  // namespace

ExitCode RunApplication(const scenario::Scenario& scenario, const RunFlags& flags, const Host& host,
                        const run::Catalogue& catalogue, std::optional<fci::Capture>& capture) {
  return Carried<ApplicationSession>(scenario, flags, host, catalogue, capture);
}

}  // namespace twin::cli
