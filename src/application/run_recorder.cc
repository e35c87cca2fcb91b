#include "application/run_recorder.h"

#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"
#include "twin/render/clip.h"
#include "twin/render/image.h"
#include "twin/replay/plan_pictures.h"
#include "twin/replay/recording.h"
#include "twin/report/plots.h"
#include "twin/run/film.h"
#include "twin/run/remote.h"
#include "twin/run/robot_config.h"

namespace twin::application {
namespace {

/// True if the run's time is the wall clock.
bool IsOnWallClock(const scenario::Scenario& scenario, const backend::Connection& connection) {
  return scenario.is_remote() ? connection.time == backend::RobotTime::kWall
                              : scenario.drive == scenario::Drive::kRealtime;
}

/// Largest resident size of the process, MB.
double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Notes that the robot is simulated in primitive shapes.
void NoteMissingMeshes(const scenario::Scenario& scenario, const backend::Connection& connection,
                       run::Console& console) {
  if (scenario.is_remote() || connection.uses_meshes ||
      scenario.plant.kind != robot::PlantKind::kMujoco) {
    return;
  }
  console.Note(
      "the robot's meshes were not found; it is simulated and drawn in primitive shapes "
      "(scripts/setup fetches them; or name them with --meshes)");
}

/// Notes the settings that have no effect on a remote robot, one line each.
void NoteIgnoredSettings(const scenario::Scenario& scenario, bool video, run::Console& console) {
  for (const std::string& text : run::WithoutEffectThere(scenario)) {
    console.Note("without effect on this robot: " + text);
  }
  if (!video) return;
  console.Note(
      "no video is made of a remote robot; run the scenario in the twin (without "
      "--backend) to see the motion");
}

/// Path of the end effector for a picture, world, m.
std::vector<Vector3> PathInWorld(const scenario::Scenario& scenario,
                                 const reference::Trajectory& trajectory, const Transform& F_T_EE) {
  std::vector<Vector3> path = EndEffectorPath(trajectory, F_T_EE);
  const Transform X_WO = scenario.robot.pose.Matrix();
  for (Vector3& p : path) {
    const Vector3 p_O = p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = X_WO[12 + i] + X_WO[i] * p_O[0] + X_WO[4 + i] * p_O[1] + X_WO[8 + i] * p_O[2];
    }
  }
  return path;
}

class MotionRecorder final : public RunRecorder {
 public:
  using RunRecorder::RunRecorder;

 private:
  Connected Connect(const run::RealtimeConfig& settings) override {
    run_.emplace(scenario(), inputs_.catalogue, inputs_.files, page_.sink(), settings);
    if (const std::string excess = run_->ProfileExcess(); !excess.empty()) {
      inputs_.console.Note(excess);
    }
    if (const auto planning = run_->planning_time()) times_.planning_s = ToSeconds(*planning);
    // The reference generator settles behind the plan: the video shows that second too.
    constexpr Duration kSettling = std::chrono::seconds(1);
    return {.connection = &run_->connection(),
            .robot = &run_->robot(),
            .check_start = [this](const run::TellCheck& tell) { return run_->CheckStart(tell); },
            .start = run_->trajectory().start(),
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
  void Draw(const render::Film& film, replay::PlanPictures& pictures) override {
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
    const double settling = simulated - ToSeconds(planned);
    inputs_.console.Show(
        "run", simulated / ToSeconds(planned),
        fmt::format("{:.1f} of {:.1f} s{}, {:.1f} x real time",
                    std::min(simulated, ToSeconds(planned)), ToSeconds(planned),
                    settling < 0.05 ? "" : fmt::format(", settling for {:.1f} s", settling),
                    simulated / SecondsSince(begin)));
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
                      .path = PathInWorld(scenario(), run_->trajectory(), F_T_EE)}};
  }
  if (report.succeeded()) return outcome;
  outcome.failure = report.failure;
  for (const Violation& violation : report.violations) outcome.cause += "; " + Describe(violation);
  if (scenario().record && report.end == backend::MotionEnd::kAborted) {
    outcome.cause += fmt::format("; why: panda-twin explain {}", out_.log().string());
  }
  return outcome;
}

/// Replaces an earlier run's results by the summary of a run that failed before its first motion.
void LeaveFailure(const RunInputs& inputs, const std::string& failure) {
  try {
    run::ResultFolder out(inputs.options.out);
    out.Prepare();
    out.Clear();
    run::WriteWholeFile(out.scenario(), scenario::ToYaml(inputs.scenario));
    run::WriteWholeFile(out.summary(), run::FailureJson(inputs.scenario, failure));
  } catch (const EnvironmentError& error) {
    inputs.console.Note(error.what());
  }
}

void Execute(const RunInputs& inputs, std::optional<fci::Capture>& capture) {
  std::unique_ptr<RunRecorder> recorder;
  try {
    recorder = inputs.scenario.application ? MakeApplicationRecorder(inputs)
                                           : std::make_unique<MotionRecorder>(inputs);
    recorder->Execute(capture);
  } catch (const InputError&) {
    throw;
  } catch (const EnvironmentError&) {
    throw;
  } catch (const Error& error) {
    const bool has_summary = recorder && recorder->has_summary();
    recorder.reset();  // unlocks the folder
    if (!has_summary && !inputs.options.hardware.check_only) LeaveFailure(inputs, error.what());
    throw;
  }
}

}  // namespace

NeededPrograms ProgramsFor(const scenario::Scenario& scenario, const RunOptions& options) {
  const bool is_filmed = !scenario.is_remote() && scenario.render.enabled &&
                         scenario.plant.kind == robot::PlantKind::kMujoco;
  return {.ffmpeg = is_filmed && options.makes_video,
          .gnuplot = scenario.record && options.makes_plots};
}

void RecordRun(const RunInputs& inputs) {
  std::optional<fci::Capture> capture;
  std::exception_ptr failure;
  try {
    Execute(inputs, capture);
  } catch (...) {
    failure = std::current_exception();
  }
  const auto note = [&inputs](std::string_view text) { inputs.console.Note(text); };
  try {  // the capture of a failed run matters most
    if (capture) run::FinishCapture(*capture, note);
  } catch (const EnvironmentError& error) {
    if (!failure) throw;
    note(error.what());
  }
  if (failure) std::rethrow_exception(failure);
}

RunRecorder::RunRecorder(const RunInputs& inputs)
    : inputs_(inputs),
      out_(inputs.options.out),
      page_(inputs.options.page, &records_, out_.folder(),
            [&console = inputs.console](std::string_view why) { console.Note(why); }),
      start_(inputs_),
      settings_(inputs.options.settings) {}

void RunRecorder::Execute(std::optional<fci::Capture>& capture) {
  Prepare(capture);
  inputs_.console.ThrowIfInterrupted();
  if (is_remote()) start_.RequireReady(run_.check_start);
  inputs_.console.ThrowIfInterrupted();
  if (inputs_.options.hardware.check_only) return inputs_.console.Say("ready; nothing has moved\n");
  OpenPage();
  try {
    start_.Confirm();
    out_.Clear();
    try {
      try {
        Perform();
      } catch (const Error& error) {
        if (!is_interrupted()) KeepInHistory(error.what());  // an older success counts no more
        throw;
      }
      WriteResults();
    } catch (...) {
      records_.Abandon();
      out_.RemovePartial(records_.log_failed());
      inputs_.console.ThrowIfInterrupted();  // takes precedence over errors that it caused
      throw;
    }
  } catch (...) {
    page_.Close("it was broken off", page::RunEnd::kFailed);
    throw;
  }
  inputs_.console.Print(
      fmt::format("{}  {:<13}{}\n", SummaryOfTerminal(), "files", out_.folder().string()));
  const std::string& lost = outcome_.lost_recording;
  if (!outcome_.failure.empty()) {
    if (!lost.empty()) inputs_.console.Note(lost);
    inputs_.console.ThrowIfInterrupted();
    KeepInHistory(outcome_.failure);
    throw RobotFault(outcome_.failure + outcome_.cause);
  }
  const std::string excess = Excess();
  KeepInHistory(excess);
  if (!lost.empty()) throw EnvironmentError(lost);
  if (excess.empty()) return;
  if (inputs_.options.strict) throw RobotFault(excess);
  inputs_.console.Warn(excess);
}

void RunRecorder::Prepare(std::optional<fci::Capture>& capture) {
  out_.RequireOther(inputs_.options.scenario);
  const auto connect = [this]() -> const backend::Connection& {
    run_ = Connect(settings_);
    return *run_.connection;
  };
  if (is_remote()) {
    NoteIgnoredSettings(scenario(), wants_video(), inputs_.console);
    if (const auto& file = inputs_.options.capture) {
      if (out_.Holds(*file)) {
        throw InputError(fmt::format(
            "--capture: {} is one of the run's own results; name another file", file->string()));
      }
      settings_.remote.capture = &capture.emplace(*file);
    }
    start_.Reach(connect);
  } else {
    connect();
  }
  NoteMissingMeshes(scenario(), *run_.connection, inputs_.console);
  if (makes_video()) {
    replay::CheckPicture(*run_.connection, scenario().render, inputs_.options.scenario);
  }
  if (!inputs_.options.hardware.check_only) out_.Prepare();
  times_.prepare_s = SecondsSince(Time());
}

void RunRecorder::OpenPage() {
  const bool is_operated =
      scenario().operator_section && scenario().operator_section->device == run::kPageDevice;
  const bool is_lockstep = scenario().is_lockstep();
  page::PageSettings settings = is_operated ? page_.Recorded() : page::PageSettings();
  settings.title = scenario().name;
  settings.about = fmt::format("{}, backend {}, drive {}{}", scenario().robot.model,
                               scenario().backend, scenario().drive_name(),
                               is_lockstep ? ", held back to the pace of the wall clock" : "");
  settings.limits = run_.robot->limits;
  if (scenario().application) settings.report = std::filesystem::absolute(out_.report()).string();
  settings.run_clock.why_not = "only the clock of drive lockstep stands";
  if (!is_operated) {
    settings.watch_only = "this run takes no commands from here; any viewer may stop it";
    settings.stop = [this] { inputs_.console.Interrupt(); };
  }
  std::optional<plant::CompiledModel> twin;  // of a robot that is not simulated here
  if (run_.connection->truth == nullptr && page_.is_wanted()) {
    twin = plant::CompileModel(run::MakeRobotConfig(scenario(), *run_.robot, inputs_.files).plant);
  }
  // In lockstep the page's thread must not ask the hand, which belongs to the run's thread.
  inputs_.console.Say(
      page_.Open(settings, scenario(),
                 {.truth = run_.connection->truth,
                  .hand = is_lockstep ? nullptr : run_.connection->hand,
                  .paced_until = is_lockstep ? &inputs_.console.interrupted() : nullptr,
                  .twin = std::move(twin)}));
  if (!inputs_.options.waits_for_visitor) return;
  inputs_.console.Note("the run begins when its page is opened");
  page_.AwaitVisitor(inputs_.console.interrupted());
  inputs_.console.ThrowIfInterrupted();
}

void RunRecorder::BeginRecords() {
  if (scenario().record) {
    // A run that does not wait for its log loses the records that find the ring full.
    records_.Log(out_.log(), run::InfoOf(scenario(), *run_.robot),
                 IsOnWallClock(scenario(), *run_.connection) ? record::FullRing::kDrop
                                                             : record::FullRing::kWait);
  }
  const plant::TruthProbe* truth = run_.connection->truth;
  if (truth == nullptr) return;
  // The log holds the scenes, with a video or without.
  if (makes_video() || (scenario().record && run::RunRecords::CanFilm(*truth))) {
    using Keep = render::SnapshotRecorder::Keep;
    records_.Film(*truth, run_.longest, scenario().render.fps,
                  makes_video() ? Keep::kAll : Keep::kLast);
  }
  records_.WatchContacts(*truth);
}

void RunRecorder::Perform() {
  BeginRecords();
  run::RunHooks hooks;
  hooks.interrupted = &inputs_.console.interrupted();
  hooks.event = [this, next = page_.Also(records_.Events())](Time at, std::string_view kind,
                                                             std::string_view text) {
    if (next) next(at, kind, text);
    inputs_.console.Debug(
        fmt::format("{:.3f} s  {}: {}", ToSeconds(at.time_since_epoch()), kind, text));
  };
  hooks.progress = [this](Time /*now*/, Duration /*planned*/) { WarnOfLostLog(); };
  const Time begin = clock_.Now();
  outcome_ = Perform(hooks);
  times_.run_s = SecondsSince(begin);
  if (const auto* seat = settings_.threads.seat) times_.run_s -= ToSeconds(seat->waited());
  times_.real_time_factor = ToSeconds(outcome_.simulated) / times_.run_s;
  for (const record::PlanRecord& plan : outcome_.plans) records_.Add(plan);
  times_.records_dropped = records_.Finish();
  for (const std::string& notice : outcome_.notices) {
    inputs_.console.Note("workstation: " + notice);
  }
  for (const std::string& notice : outcome_.robot.notices) inputs_.console.Note("robot: " + notice);
  Evaluate(outcome_);
  if (outcome_.failure.empty()) {
    page_.Close("it went well", page::RunEnd::kDone);
  } else {
    page_.Close(outcome_.failure, page::RunEnd::kFailed);
  }
}

void RunRecorder::WarnOfLostLog() {
  const std::string failure = warned_of_log_ ? std::string() : records_.LogFailure();
  if (failure.empty()) return;
  warned_of_log_ = true;
  inputs_.console.Warn(failure + ". The run goes on without its log");
}

void RunRecorder::WriteResults() {
  run::WriteWholeFile(out_.scenario(), scenario::ToYaml(scenario()));
  std::string summary = SummaryOfFile();
  if (inputs_.options.hardware.allowed) {
    auto json = nlohmann::ordered_json::parse(summary);
    json["hardware"] = start_.Record();
    summary = run::TextOf(json);
  }
  run::WriteWholeFile(out_.summary(), summary);
  has_summary_ = true;
  if (!is_interrupted()) {
    std::vector<std::filesystem::path> plots;
    if (scenario().record && inputs_.options.makes_plots) {
      const Time begin = clock_.Now();
      inputs_.console.Print("plots ...\n");
      plots = report::WritePlots(out_.log(), run_.robot->limits, out_.plots());
      times_.plots_s = SecondsSince(begin);
    }
    if (is_filmed()) MakePictures();
    if (inputs_.options.makes_plots) WriteReport(plots);
  }
  times_.peak_memory_mb = PeakMemoryMb();
  run::WriteWholeFile(out_.timing(), run::TimingJson(times_, outcome_.robot));
}

void RunRecorder::MakePictures() {
  const plant::TruthProbe& truth = *run_.connection->truth;
  const render::Film film = replay::FilmOfRun(truth.model(), *records_.snapshots(), scenario(),
                                              records_.plans(), records_.events());
  render::FilmSettings settings = run::FilmOf(scenario().render);
  if (inputs_.options.has_fine_pictures) settings = run::Fine(settings);
  times_.video_s = replay::RenderClip(render::FramesOf(film, settings),
                                      {out_.video(), out_.contact_sheet()}, clock_, inputs_.console)
                       .seconds;
  if (film.goals.empty()) return;
  settings.overlays = {.text = false};
  replay::PlanPictures pictures(film, settings);
  Draw(film, pictures);
}

std::string RunRecorder::Excess() const {
  const std::vector<run::FollowedMotion>& motions = outcome_.followed;
  const auto exceeding = std::ranges::count_if(motions, &run::FollowedMotion::exceeds);
  if (exceeding == 0) return {};
  const run::FollowedMotion& first = *std::ranges::find_if(motions, &run::FollowedMotion::exceeds);
  const std::string whose = motions.size() == 1
                                ? std::string()
                                : fmt::format("in {} of {} motions, first in {}: ", exceeding,
                                              motions.size(), first.name);
  return fmt::format("the arm was off its path: {}{} (max_deviation)", whose, first.Excess());
}

void RunRecorder::KeepInHistory(const std::string& failure) const {
  const HardwareOptions& hardware = inputs_.options.hardware;
  if (hardware.history == nullptr) return;
  try {
    hardware.history->Keep({.hash = hardware.rehearsal.hash,
                            .scenario = scenario().name,
                            .robot = hardware.allowed ? NameOf(settings_.remote) : std::string(),
                            .failure = failure,
                            .max_speed = hardware.rehearsal.max_speed,
                            .q_start = run_.start});
  } catch (const EnvironmentError& error) {
    inputs_.console.Note(error.what());
  }
}

}  // namespace twin::application
