#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/serve_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/page_operator.h"
#include "twin/application/session_results.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/reference/viable_axis.h"
#include "twin/robot/robot_config.h"
#include "twin/run/operator_page.h"
#include "twin/run/result_folder.h"
#include "twin/run/run.h"
#include "twin/run/run_records.h"
#include "twin/run/told_events.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/control_channel.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

/// A served robot, from flags to the end.
class Service {
 public:
  Service(const ServeFlags& flags, const Program& program)
      : flags_(flags),
        program_(program),
        files_(FilesOf(flags.data, program)),
        drive_(DriveOf(flags)),
        reset_(ResetPolicyOf(flags, drive_)),
        scenario_(ServedScenarioOf(flags, drive_, program.host)) {
    if (flags.out) PrepareResults();
    robot::RobotConfig robot = run::MakeServedConfig(scenario_, files_);
    robot.viability = flags_.viability;
    robot.onboard.guard = GuardOf(flags_, scenario_);
    server::ServedRobotSettings settings = MakeSettings();
    robot::MadePlant plant = robot::MakePlant(robot);
    page_.emplace(flags_.page.wanted() ? std::optional(PageAt(flags_.page)) : std::nullopt,
                  has_log() ? &told_ : nullptr, out_ ? out_->folder() : ".",
                  [this](std::string_view text) { program_.log->info(text); });
    settings.sink = page_->sink();
    if (flags_.capture) settings.server.capture = &capture_.emplace(*flags_.capture);
    robot_.emplace(robot, std::move(plant), std::move(settings));
  }
  ~Service() {
    ClosePage();  // it looks at the robot
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  int Run();

 private:
  /// Short of log and capture.
  [[nodiscard]] server::ServedRobotSettings MakeSettings();
  /// Takes the folder of --out. @throws twin::Error when it, or a program for it, is not to be had.
  void PrepareResults();
  [[nodiscard]] bool has_log() const { return flags_.log || flags_.out; }
  /// As the last thing before the robot's time: an earlier session's results go when nothing can
  /// prevent this one any more.
  void MakeLog();
  /// As the log has it. Without a scenario the motion is the client's alone; the log gets one at
  /// rest, so that it can be read as any other.
  [[nodiscard]] scenario::Scenario LoggedScenario() const;
  /// An operator who takes control at the page leads the robot, unless it is as fast as programs
  /// answer. STOP presses the robot's user stop, and the operator's release lets it go.
  void OpenPage();
  /// The same clock as the control channel's pause and resume.
  [[nodiscard]] page::RunClock RunClock();
  void PressUserStop(bool pressed);
  void ClosePage();
  [[nodiscard]] scenario::RobotData DataOfRobot() const {
    return scenario::LoadRobotData(files_.models, scenario_.robot.model, scenario_.robot.hand);
  }
  void Introduce();
  /// The results of --out. A second wish to end leaves out the plots and the film that are left.
  void WriteResults();
  /// Threads: any.
  void Tell(std::string_view line);
  [[nodiscard]] bool Ends();
  /// Says, once each, that log or capture cannot be written any more.
  void TellLosses();
  [[nodiscard]] bool is_unpaced() const { return drive_.is_lockstep() && !drive_.pace; }

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  const Program& program_;
  const run::RunFiles files_;
  const ServeDrive drive_;
  const ResetPolicy reset_;
  const scenario::Scenario scenario_;
  const InterruptGuard interrupt_;
  std::optional<EventLog> events_;  ///< from Run() to the end
  std::optional<run::ResultFolder> out_;
  run::RunRecords records_;  ///< of the log
  run::ToldEvents told_{records_};
  std::optional<fci::Capture> capture_;
  std::mutex telling_;
  bool told_of_log_ = false;
  bool told_of_capture_ = false;
  std::optional<run::OperatorPage> page_;
  std::optional<server::ServedRobot> robot_;
  std::optional<server::ControlChannel> control_;  ///< while the robot's time runs
  std::unique_ptr<application::PageOperator>
      operator_;  ///< from before the page is open until it has ended
};

void Service::PrepareResults() {
  out_.emplace(*flags_.out);
  if (!flags_.scenario.empty()) out_->RequireOther(flags_.scenario);
  if (flags_.capture && out_->Holds(*flags_.capture)) {
    throw InputError(
        fmt::format("--capture: {} is one of the session's own results; name another "
                    "file",
                    flags_.capture->string()));
  }
  RequireProgram("gnuplot", program_.host.path, "apt-get install gnuplot-nox, or serve with --log");
  if (scenario_.render.enabled && !flags_.no_video) {
    RequireProgram("ffmpeg", program_.host.path, "apt-get install ffmpeg, or add --no-video");
  }
  out_->Prepare();
}

scenario::Scenario Service::LoggedScenario() const {
  scenario::Scenario logged = scenario_;
  if (!flags_.scenario.empty()) return logged;
  const reference::Waypoint stand{.q = logged.robot.q_start.value()};
  logged.motion.waypoints = {stand, stand};
  return logged;
}

void Service::MakeLog() {
  if (out_) out_->Clear();
  if (!has_log()) return;
  records_.Log(out_ ? out_->log() : *flags_.log, run::InfoOf(LoggedScenario(), DataOfRobot()),
               drive_.is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop);
  // With scenes, so that pictures of it show hand and objects as they were, and with what the arm
  // touched when errors were raised.
  constexpr Duration kForever = std::chrono::hours(24 * 365);
  const plant::TruthProbe* truth = robot_->truth();
  if (truth == nullptr) return;
  records_.WatchContacts(*truth);
  if (!run::RunRecords::CanFilm(*truth)) return;
  records_.Film(*truth, kForever, scenario_.render.fps, render::SnapshotRecorder::Keep::kLast);
}

server::ServedRobotSettings Service::MakeSettings() {
  server::ServedRobotSettings settings;
  Listen(flags_.network, settings.server);
  settings.server.model_library = ModelLibraryOf(program_);
  if (drive_.is_lockstep()) {
    settings.lockstep = {.answer_timeout = FromSeconds(flags_.session_timeout),
                         .freeze_when_idle = FreezesWhenIdle(flags_),
                         .pace = drive_.pace};
  }
  if (reset_ == ResetPolicy::kOnConnect) {
    settings.server.on_arm_client = [this] {
      if (!robot_->lockstep()->Reset({})) Tell("arm: not reset: the hand executes a command");
    };
  }
  settings.tell = [this](std::string_view line) { Tell(line); };
  return settings;
}

void Service::Tell(std::string_view line) {
  const Time now = clock_.Now();
  const std::scoped_lock lock(telling_);
  events_->Put(ToSeconds(now.time_since_epoch()), line);
  if (has_log()) told_.Tell(line);
  if (page_) page_->Tell("server", line);
}

void Service::Introduce() {
  events_->Put(IntroductionOf(flags_, drive_, scenario_, *robot_));
}

void Service::TellLosses() {
  const auto tell = [this](bool& told, const std::string& failure) {
    if (told || failure.empty()) return;
    told = true;
    program_.log->warn("{}. It goes on without", failure);
  };
  tell(told_of_log_, records_.LogFailure());
  if (capture_) tell(told_of_capture_, capture_->Failure());
}

void Service::OpenPage() {
  if (!page_->is_wanted()) return;
  page::PageSettings settings = is_unpaced() ? page::PageSettings() : page_->Recorded();
  settings.title = scenario_.name.empty() ? "panda-twin serve" : scenario_.name;
  settings.about = fmt::format("{}, served at {}, drive {}", scenario_.robot.model,
                               fci::ToString(robot_->arm()), scenario_.drive_name());
  settings.limits = DataOfRobot().limits;
  settings.stop = [this] { PressUserStop(true); };
  settings.release = [this] { PressUserStop(false); };
  if (out_) settings.report = std::filesystem::absolute(out_->report()).string();
  settings.run_clock = RunClock();
  if (is_unpaced()) {
    settings.watch_only =
        "a robot served in lockstep is as fast as programs answer: serve it with --pace 1 to lead "
        "it";
  } else {
    operator_ = std::make_unique<application::PageOperator>(
        application::PageOperator::Parts{program_.catalogue, files_, page_->channel(),
                                         [this] { return page_->FreeBodies(); },
                                         drive_.pace.value_or(1)},
        scenario_, robot_->arm(), robot_->hand(),
        [this](Time /*at*/, std::string_view kind, std::string_view text) {
          page_->Tell(kind, text);
        });
    operator_->Offer(settings);
  }
  Say(stdout, page_->Open(settings, scenario_, {.truth = robot_->truth()}));
  std::fflush(stdout);
}

page::RunClock Service::RunClock() {
  robot::AnswerPacedRobot* const lockstep = robot_->lockstep();
  if (lockstep == nullptr) {
    return {.why_not = "only the clock of drive lockstep stands"};
  }
  return {.is_paused = [lockstep] { return lockstep->cycles_left().has_value(); },
          .pause = [lockstep](bool on) { on ? lockstep->Pause() : lockstep->Resume(); },
          .why_not = {}};
}

void Service::PressUserStop(bool pressed) {
  try {
    robot_->PressUserStop(pressed);
  } catch (const Error& error) {
    page_->Tell("error", error.what());
  }
}

void Service::ClosePage() {
  page_->Close("the robot is served no more", page::RunEnd::kDone);
  operator_.reset();
}

bool Service::Ends() {
  TellLosses();
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

int Service::Run() {
  interrupt_.ThrowIfInterrupted();
  OpenPage();
  events_.emplace(*program_.log_flags);
  if (flags_.control) {
    const auto place = [this](const std::string& name, const Transform& X_WB) {
      robot_->Place(name, X_WB);
    };
    control_.emplace(*flags_.control,
                     server::ControlChannel::Controlled{.robot = robot_->robot(),
                                                        .lockstep = robot_->lockstep(),
                                                        .place = place,
                                                        .may_reset = reset_ != ResetPolicy::kNever},
                     [this](std::string_view line) { Tell(line); });
  }
  MakeLog();
  robot_->Begin();
  for (const std::string& notice : robot_->notices()) program_.log->info("robot: {}", notice);
  Introduce();
  robot_->Serve([this] { return Ends(); });
  control_.reset();
  ClosePage();
  robot_->End();
  told_.Finish();
  static_cast<void>(records_.Finish());
  if (capture_) {
    run::FinishCapture(*capture_, [this](std::string_view text) { program_.log->info(text); });
  }
  const bool is_interrupted = interrupt_.interrupted();
  if (out_) WriteResults();
  const std::string warnings = robot_->DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return is_interrupted ? kInterrupted : kOk;
}

void Service::WriteResults() {
  interrupt_.Rearm();
  events_.reset();  // the terminal writes to standard output
  Terminal terminal(program_.log, program_.is_quiet());
  const plant::TruthProbe* truth = robot_->truth();
  const bool has_scenes = truth != nullptr && run::RunRecords::CanFilm(*truth);
  const scenario::Scenario logged = LoggedScenario();
  const scenario::RobotData robot = DataOfRobot();
  application::WriteSessionResults(
      {.out = *out_,
       .scenario = logged,
       .robot = robot,
       .files = files_,
       .makes_video = has_scenes && scenario_.render.enabled && !flags_.no_video,
       .facts = {{"robot", scenario_.robot.model},
                 {"seed", fmt::format("{}", scenario_.seed)},
                 {"drive", std::string(scenario_.drive_name())},
                 {"panda-twin", TWIN_VERSION}},
       .console = terminal});
  terminal.Print(fmt::format("  report  {}\n", out_->report().string()));
}

int Serve(const ServeFlags& flags, const Program& program) {
  RequireServeAgreement(flags);
  return Service(flags, program).Run();
}

}  // namespace

void AddServe(CLI::App& app, Program& program) {
  const auto [serve, flags] = AddCommand(
      app, program, "serve", "Serve a robot to programs made for it (FCI protocol 5)", &Serve);
  Add(serve, "scenario FILE", flags.scenario, "Scenario file (default: the ready pose, no scene)");
  AddLab(serve, flags.lab);
  Add(serve, "--scene FILE", flags.scene,
      "World around the robot (MJCF, here or in the models folder)");
  AddNetwork(serve, flags.network);
  Add(serve, "--drive", flags.drive,
      "Who advances time: realtime or lockstep (default: realtime where this host keeps 1 kHz, "
      "else lockstep --pace 1)");
  Add(serve, "--pace N", flags.pace,
      "lockstep: never faster than N times the wall clock (default: as fast as answers come)");
  Add(serve, "--idle", flags.idle, "lockstep: time between motions: run or freeze")
      ->capture_default_str();
  Add(serve, "--reset", flags.reset,
      "lockstep: begin anew for each client of the arm (on-connect), when ctl says so "
      "(on-command), or never")
      ->capture_default_str();
  Add(serve, "--clock-ppm PPM", flags.clock_ppm, "realtime: drift of the robot's clock");
  Add(serve, "--session-timeout S", flags.session_timeout,
      "lockstep: a motion that is not answered for so long is stopped")
      ->capture_default_str();
  Add(serve, "--viability N", flags.viability,
      "Keep the clients' motions within the limits, whatever up to N commands in a row "
      "are lost; 19 bridges all that no robot aborts for")
      ->check(CLI::Range(0, reference::ViableAxis::kMostLost));
  serve.add_flag(
      "--guard", flags.guard,
      "The robot keeps the limits of scenario and lab: it stops a client's motion, as by "
      "a reflex, before the motion breaks one");
  AddSeed(serve, flags.seed);
  Add(serve, "--out DIR", flags.out,
      "Folder of results: log, report with a row per motion, plots, explanations, video");
  serve.add_flag("--no-video", flags.no_video, "With --out: make no video and no contact sheet");
  Add(serve, "--log FILE", flags.log, "Write every cycle (MCAP)");
  Add(serve, "--capture FILE", flags.capture, "Keep what goes over the wire (pcapng; see decode)");
  Add(serve, "--control FILE", flags.control,
      "Let programs on this machine pause, step and stop the robot over this Unix socket (see ctl)");
  AddPage(serve, flags.page);
  Add(serve, "--for S", flags.seconds, "End after so long");
  AddData(serve, flags.data);
}

}  // namespace twin::cli
