#include <optional>
#include <string>

#include <fmt/format.h>

#include "cli/application_command.h"
#include "cli/commands.h"
#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/picture.h"
#include "cli/plan_records.h"
#include "cli/progress.h"
#include "cli/remote_run.h"
#include "cli/result_folder.h"
#include "cli/run_page.h"
#include "cli/run_records.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "cli/seeds_command.h"
#include "cli/snapshot_pictures.h"
#include "cli/summary.h"
#include "cli/wire_capture.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/report/plots.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

/// One run from its flags to its results.
class Session {
 public:
  /// @param capture  is made when the flags want one; must outlive the session.
  Session(const scenario::Scenario& scenario, const RunFlags& flags, const Host& host,
          const run::Catalogue& catalogue, std::optional<fci::Capture>& capture)
      : flags_(flags),
        scenario_(scenario),
        settings_(SettingsOf(flags)),
        out_(OutOf(scenario_, flags)),
        page_(flags, records_, interrupt_, out_.folder()) {
    RequirePrograms(scenario_, wants_video(), host);
    const run::RunFiles files = FilesOf(flags, host);
    if (flags.max_speed) SlowDown(scenario_, files.models, *flags.max_speed);
    Connect(
        scenario_, flags, wants_video(), settings_, capture, [&]() -> const auto& {
          run_.emplace(scenario_, catalogue, files, page_.sink(), settings_);
          return run_->connection();
        });
    TellIfWithoutMeshes(scenario_, run_->connection());
    if (makes_video()) CheckPicture(run_->connection(), scenario_.render, flags.scenario);
    out_.Prepare();
    times_.prepare_s = SecondsSince(Time());
    if (const auto planning = run_->planning_time()) times_.planning_s = ToSeconds(*planning);
  }

  ExitCode Execute();
  /// Whether the folder of results holds this run's summary.
  [[nodiscard]] bool has_summary() const noexcept { return has_summary_; }

 private:
  void Move();
  void WriteResults();
  void MakePictures();
  void MakePlots();
  /// --no-video is no part of the scenario: log and plots are the same with and without.
  [[nodiscard]] bool wants_video() const { return scenario_.render.enabled && !flags_.no_video; }
  [[nodiscard]] bool makes_video() const {
    return wants_video() && run_->connection().truth != nullptr;
  }
  [[nodiscard]] bool is_simulated() const { return scenario_.drive != scenario::Drive::kRemote; }
  [[nodiscard]] double SecondsSince(Time begin) const { return ToSeconds(clock_.Now() - begin); }

  const MonotonicClock clock_;
  const RunFlags& flags_;
  scenario::Scenario scenario_;     ///< as it is run; not changed after the constructor
  run::RealtimeSettings settings_;  ///< not changed after the constructor
  ResultFolder out_;
  const InterruptGuard interrupt_;
  WallTimes times_;
  RunRecords records_;
  RunPage page_;
  std::optional<run::Run> run_;
  run::RunResult result_;
  bool has_summary_ = false;
};

ExitCode Session::Execute() {
  interrupt_.ThrowIfInterrupted();
  if (!is_simulated()) {
    RequireReady([this](const run::TellCheck& tell) { return run_->CheckStart(tell); });
  }
  interrupt_.ThrowIfInterrupted();
  const RunPage::Opening opening = page_.Open(scenario_, run_->robot(), run_->connection());
  out_.Clear();
  CarryOut(records_, out_, interrupt_, [this] {
    Move();
    WriteResults();
  });
  const bool interrupted = interrupt_.interrupted();
  if (!flags_.quiet) {
    Say(stdout,
        fmt::format("{}  {:<13}{}\n",
                    SummaryText(scenario_, result_, interrupted, times_, records_.contacts()),
                    "files", out_.folder().string()));
  }
  if (result_.report.succeeded()) {
    EvaluateDeviations({result_.followed}, flags_.strict);
    return kOk;
  }
  if (interrupted) throw Interrupted();
  std::string text = result_.report.failure;
  for (const Violation& violation : result_.report.violations) text += "; " + Describe(violation);
  if (scenario_.record && result_.report.end == backend::MotionEnd::kAborted) {
    text += fmt::format("; why: panda-twin explain {}", out_.log().string());
  }
  throw RobotFault(text);
}

void Session::Move() {
  BeginLog(records_, out_.log(), scenario_, run_->robot(), settings_);
  const run::Run& run = *run_;
  const plant::TruthProbe* truth = run.connection().truth;
  // Logs are the same with a video and without.
  const bool logs_scenes = scenario_.record && truth != nullptr && RunRecords::CanFilm(*truth);
  if (makes_video() || logs_scenes) {
    using Keep = render::SnapshotRecorder::Keep;
    // The reference generator settles behind the plan: frames of that second belong to the video.
    constexpr Duration kSettling = std::chrono::seconds(1);
    records_.Film(*truth, run.trajectory().duration() + kSettling, scenario_.render.fps,
                  makes_video() ? Keep::kAll : Keep::kLast);
  }
  if (truth != nullptr) records_.WatchContacts(*truth);

  Progress progress("run", Progress::StyleOfStdout(flags_.quiet), clock_);
  const Time begin = clock_.Now();
  run::RunHooks hooks;
  hooks.interrupted = interrupt_.flag();
  hooks.progress = [&](Time now, Duration planned) {
    const double simulated = ToSeconds(now.time_since_epoch());
    progress.Show(simulated / ToSeconds(planned),
                  fmt::format("{:.1f} of {:.1f} s, {:.1f} x real time", simulated,
                              ToSeconds(planned), simulated / SecondsSince(begin)));
  };
  hooks.event = page_.Also(records_.Events());
  result_ = run_->Execute(hooks);
  page_.Close(result_.report.succeeded() ? "it went well" : result_.report.failure);
  times_.run_s = SecondsSince(begin);
  times_.real_time_factor = ToSeconds(result_.report.simulated) / times_.run_s;
  if (run.planning_time()) records_.Add(PlanOf(run, scenario_, Time(result_.report.simulated)));
  times_.records_dropped = records_.Finish();
  TellNotices(result_.report.notices, result_.report.robot_timings.notices);
}

void Session::WriteResults() {
  const bool interrupted = interrupt_.interrupted();
  WriteWholeFile(out_.scenario(), scenario::ToYaml(scenario_));
  WriteWholeFile(out_.summary(), SummaryJson(scenario_, result_, interrupted, records_.contacts()));
  has_summary_ = true;
  if (!interrupted && scenario_.record) MakePlots();
  if (!interrupted && makes_video() && records_.was_filmed()) MakePictures();
  times_.peak_memory_mb = PeakMemoryMb();
  WriteWholeFile(out_.timing(), TimingJson(times_, result_.report.robot_timings));
}

void Session::MakePictures() {
  const render::Film film = records_.FilmOf(scenario_);
  const render::FilmSettings settings = FilmOf(scenario_.render);
  times_.video_s = ShowClip(render::FramesOf(film, settings), {out_.video(), out_.contact_sheet()},
                            interrupt_, clock_, flags_.quiet)
                       .seconds;
  if (!film.goals.empty()) DrawPlannedMotion(film, settings, out_);
}

void Session::MakePlots() {
  const Time begin = clock_.Now();
  if (!flags_.quiet) Say(stdout, "plots ...\n");
  report::WritePlots(out_.log(), run_->robot().limits, out_.plots());
  times_.plots_s = SecondsSince(begin);
}

}  // namespace

ExitCode RunCommand(const RunFlags& flags, const Host& host, const run::Catalogue& catalogue) {
  std::optional<fci::Capture> capture;
  try {
    const scenario::Scenario scenario = LoadWithFlags(flags, host);
    RequirePageFlags(flags.page);
    if (flags.seeds && flags.page.wanted()) {
      throw InputError("--page shows one run; leave out --seeds, or the page");
    }
    if (flags.seeds && flags.strict) {
      throw InputError("--strict judges one run; leave out --seeds, or --strict");
    }
    if (flags.seeds) return RunManySeeds(scenario, flags, host, catalogue);
    const ExitCode code = scenario.application
                              ? RunApplication(scenario, flags, host, catalogue, capture)
                              : Carried<Session>(scenario, flags, host, catalogue, capture);
    if (capture) FinishCapture(*capture);
    return code;
  } catch (...) {
    KeepAfterFailure(capture);
    throw;
  }
}

}  // namespace twin::cli
