#include <sys/resource.h>

#include <optional>
#include <string>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/picture.h"
#include "cli/progress.h"
#include "cli/remote_run.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "cli/summary.h"
#include "cli/wire_capture.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/record/recorder.h"
#include "twin/render/clip.h"
#include "twin/render/snapshots.h"
#include "twin/report/deviation.h"
#include "twin/report/plots.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

/// Where a run's records go: to the log, and to the camera. Connected once the run is assembled,
/// before its first cycle.
class Records final : public rt::RecordSink {
 public:
  void Connect(record::Recorder* log, render::SnapshotRecorder* camera,
               const plant::TruthProbe* truth) noexcept {
    log_ = log;
    camera_ = camera;
    truth_ = truth;
  }
  void Put(const rt::CycleRecord& record) noexcept override {
    if (camera_ != nullptr) camera_->Capture(record.at, *truth_);
    if (log_ != nullptr) log_->Put(record);
  }
  void Put(const rt::TickRecord& record) noexcept override {
    if (log_ != nullptr) log_->Put(record);
  }

 private:
  record::Recorder* log_ = nullptr;
  render::SnapshotRecorder* camera_ = nullptr;
  const plant::TruthProbe* truth_ = nullptr;
};

scenario::Scenario LoadWithFlags(const RunFlags& flags) {
  scenario::Scenario scenario = scenario::Load(flags.scenario);
  if (flags.seed) scenario.seed = *flags.seed;
  if (flags.backend) ChooseBackend(*flags.backend, scenario);
  if (flags.drive) scenario.drive = scenario::DriveFromName(*flags.drive);
  RequireRemoteFlags(flags, scenario);
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  if (scenario.drive == scenario::Drive::kLockstep && (flags.ext_cpu || flags.int_cpu)) {
    throw InputError("--ext-cpu and --int-cpu go with --drive realtime: lockstep has one thread");
  }
  scenario.Validate();
  return scenario;
}

scenario::RealtimeSettings SettingsOf(const RunFlags& flags) {
  scenario::RealtimeSettings settings;
  settings.robot.cpu = flags.int_cpu;
  settings.threads.communication.cpu = flags.ext_cpu;
  if (flags.robot) {
    settings.remote = scenario::ParseRemote(*flags.robot, flags.robot_time.value_or("wall"));
  }
  return settings;
}

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// One run from its flags to its results.
class Session {
 public:
  /// @param capture  is made when the flags want one; must outlive the session.
  Session(const RunFlags& flags, const Host& host, const scenario::Catalogue& catalogue,
          std::optional<fci::Capture>& capture)
      : flags_(flags),
        scenario_(LoadWithFlags(flags)),
        settings_(SettingsOf(flags)),
        capture_(capture),
        out_(flags.out.empty() ? std::filesystem::path("out") / scenario_.name : flags.out) {
    RequirePrograms(host);
    const auto data =
        scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
    if (flags.max_speed) SlowDown(scenario_, data.models, *flags.max_speed);
    Assemble(catalogue,
             scenario::RunFiles{data.models, data.mesh_package, host.cache, flags.rebuild_cache});
    if (is_simulated() && scenario_.plant.kind == robot::PlantKind::kMujoco &&
        !run_->connection().uses_meshes) {
      Say(stderr,
          "panda-twin: note: the robot's meshes were not found; it is simulated and drawn in "
          "primitive shapes (scripts/setup fetches them; or name them with --meshes)\n");
    }
    if (makes_video()) CheckPicture(*run_, scenario_.render);
    out_.Prepare();
    times_.prepare_s = SecondsSince(Time());
  }

  ExitCode Execute();

 private:
  void RequirePrograms(const Host& host) const;
  void Assemble(const scenario::Catalogue& catalogue, const scenario::RunFiles& files);
  void Move();
  void WriteResults();
  void MakePlots();
  void MakeVideo();
  /// --no-video is no part of the scenario: log and plots are the same with and without.
  [[nodiscard]] bool wants_video() const { return scenario_.render.enabled && !flags_.no_video; }
  [[nodiscard]] bool makes_video() const {
    return wants_video() && run_->connection().truth != nullptr;
  }
  [[nodiscard]] bool is_simulated() const { return scenario_.drive != scenario::Drive::kRemote; }
  /// Whether what is late is lost: the log's records too.
  [[nodiscard]] bool waits_for_nobody() const {
    if (is_simulated()) return scenario_.drive == scenario::Drive::kRealtime;
    return settings_.remote.time == backend::RobotTime::kWall;
  }
  [[nodiscard]] double SecondsSince(Time begin) const { return ToSeconds(clock_.Now() - begin); }
  [[nodiscard]] Progress MakeProgress(const char* what) const {
    return Progress(what, Progress::StyleOfStdout(flags_.quiet), clock_);
  }

  const MonotonicClock clock_;
  const RunFlags& flags_;
  scenario::Scenario scenario_;          ///< as it is run; not changed after the constructor
  scenario::RealtimeSettings settings_;  ///< not changed after the constructor
  std::optional<fci::Capture>& capture_;
  ResultFolder out_;
  const InterruptGuard interrupt_;
  WallTimes times_;
  Records records_;
  std::optional<scenario::Run> run_;
  std::optional<render::SnapshotRecorder> camera_;
  scenario::RunResult result_;
  std::optional<report::Deviation> deviation_;
};

void Session::RequirePrograms(const Host& host) const {
  if (is_simulated() && wants_video() && scenario_.plant.kind == robot::PlantKind::kMujoco) {
    RequireProgram("ffmpeg", host.path, "apt-get install ffmpeg, or run with --no-video");
  }
  if (scenario_.record) {
    RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox, or say record: false");
  }
}

void Session::Assemble(const scenario::Catalogue& catalogue, const scenario::RunFiles& files) {
  if (is_simulated()) {
    run_.emplace(scenario_, catalogue, files, &records_, settings_);
    return;
  }
  TellWhatHasNoEffect(scenario_, wants_video());
  if (flags_.capture) settings_.remote.capture = &capture_.emplace(*flags_.capture);
  TellReach(settings_.remote, [&] {
    run_.emplace(scenario_, catalogue, files, &records_, settings_);
    return run_->connection().backend->Describe().robot;
  });
}

ExitCode Session::Execute() {
  interrupt_.ThrowIfInterrupted();
  if (!is_simulated()) RequireReady(*run_);
  interrupt_.ThrowIfInterrupted();
  out_.Clear();
  try {
    Move();
    WriteResults();
  } catch (...) {
    out_.RemovePartial();
    interrupt_.ThrowIfInterrupted();  // whatever else that led to
    throw;
  }
  const bool interrupted = interrupt_.interrupted();
  if (!flags_.quiet) {
    Say(stdout, fmt::format("{}  {:<13}{}\n",
                            SummaryText(scenario_, result_, interrupted, times_, deviation_),
                            "files", out_.folder().string()));
  }
  if (result_.report.succeeded()) return kOk;
  if (interrupted) throw Interrupted();
  std::string text = result_.report.failure;
  for (const Violation& violation : result_.report.violations) text += "; " + Describe(violation);
  if (scenario_.record && result_.report.end == backend::MotionEnd::kAborted) {
    text += fmt::format("; why: panda-twin explain {}", out_.log().string());
  }
  throw RobotFault(text);
}

void Session::Move() {
  std::optional<record::Recorder> log;
  if (scenario_.record) {
    log.emplace(out_.log(),
                record::RunInfo{scenario_.name, scenario_.seed, TWIN_VERSION,
                                std::string(Name(scenario_.drive)), scenario::ToYaml(scenario_),
                                record::RunLimits{run_->robot().limits, run_->robot().cartesian}},
                waits_for_nobody() ? record::FullRing::kDrop : record::FullRing::kWait);
  }
  const scenario::Run& run = *run_;
  if (makes_video()) {
    // The reference generator settles behind the plan: frames of that second belong to the video.
    constexpr Duration kSettling = std::chrono::seconds(1);
    camera_.emplace(run.trajectory().duration() + kSettling, scenario_.render.fps,
                    run.connection().truth->qpos_size());
  }
  records_.Connect(log ? &*log : nullptr, camera_ ? &*camera_ : nullptr, run.connection().truth);

  Progress progress = MakeProgress("run");
  const Time begin = clock_.Now();
  scenario::RunHooks hooks;
  hooks.interrupted = interrupt_.flag();
  hooks.progress = [&](Time now, Duration planned) {
    const double simulated = ToSeconds(now.time_since_epoch());
    progress.Show(simulated / ToSeconds(planned),
                  fmt::format("{:.1f} of {:.1f} s, {:.1f} x real time", simulated,
                              ToSeconds(planned), simulated / SecondsSince(begin)));
  };
  if (log) {
    hooks.event = [&](Time at, std::string_view kind, std::string_view text) {
      log->Event(at, kind, text);
    };
  }
  result_ = run_->Execute(hooks);
  times_.run_s = SecondsSince(begin);
  times_.real_time_factor = ToSeconds(result_.report.simulated) / times_.run_s;
  if (log) times_.records_dropped = log->Finish().dropped;
  for (const auto* notices : {&result_.report.notices, &result_.report.robot_timings.notices}) {
    for (const std::string& notice : *notices) {
      Say(stderr,
          fmt::format("panda-twin: note: {}: {}\n",
                      notices == &result_.report.notices ? "workstation" : "robot", notice));
    }
  }
}

void Session::WriteResults() {
  const bool interrupted = interrupt_.interrupted();
  WriteWholeFile(out_.scenario(), scenario::ToYaml(scenario_));
  if (scenario_.record) deviation_ = report::MeasureDeviation(out_.log());
  WriteWholeFile(out_.summary(), SummaryJson(scenario_, result_, interrupted, deviation_));
  if (!interrupted && scenario_.record) MakePlots();
  if (!interrupted && makes_video()) MakeVideo();
  times_.peak_memory_mb = PeakMemoryMb();
  WriteWholeFile(out_.timing(), TimingJson(times_, result_.report.robot_timings));
}

void Session::MakePlots() {
  const Time begin = clock_.Now();
  if (!flags_.quiet) Say(stdout, "plots ...\n");
  report::WritePlots(out_.log(), run_->robot().limits, out_.plots());
  times_.plots_s = SecondsSince(begin);
}

void Session::MakeVideo() {
  const render::Snapshots& snapshots = camera_->snapshots();
  if (snapshots.size() == 0) return;
  render::ClipSettings settings;
  settings.render = PictureOf(scenario_.render);
  Progress progress = MakeProgress("video");
  const render::ClipStats stats = render::RenderClip(
      run_->connection().truth->model(), snapshots, settings, {out_.video(), out_.contact_sheet()},
      clock_, [&](std::size_t done, std::size_t total) {
        interrupt_.ThrowIfInterrupted();
        progress.Show(static_cast<double>(done) / static_cast<double>(total),
                      fmt::format("{} of {} frames", done, total));
      });
  times_.video_s = stats.seconds;
}

/// What was captured of a run that failed is wanted most. What fails here is told beside it.
void KeepAfterFailure(std::optional<fci::Capture>& capture) {
  if (!capture) return;
  try {
    FinishCapture(*capture);
  } catch (const EnvironmentError& error) {
    Say(stderr, fmt::format("panda-twin: note: {}\n", error.what()));
  }
}

}  // namespace

ExitCode RunCommand(const RunFlags& flags, const Host& host, const scenario::Catalogue& catalogue) {
  std::optional<fci::Capture> capture;
  try {
    const ExitCode code = Session(flags, host, catalogue, capture).Execute();
    if (capture) FinishCapture(*capture);
    return code;
  } catch (...) {
    KeepAfterFailure(capture);
    throw;
  }
}

}  // namespace twin::cli
