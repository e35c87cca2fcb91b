#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/shared_flags.h"
#include "twin/application/page_operator.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/loop/host_timing.h"
#include "twin/reference/viable_axis.h"
#include "twin/robot/robot_config.h"
#include "twin/run/operator_page.h"
#include "twin/run/remote.h"
#include "twin/run/run.h"
#include "twin/run/run_records.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

struct ServeFlags {
  std::filesystem::path scenario;              ///< robot, scene, start; empty: the ready pose
  std::optional<std::string> lab;              ///< as run's
  std::optional<std::filesystem::path> scene;  ///< instead of the scenario's
  std::optional<std::uint64_t> seed;
  NetworkFlags network;
  std::optional<std::string> drive;  ///< absent: by what this host keeps
  std::optional<double> pace;        ///< lockstep: robot time over wall-clock time, at most
  std::string idle = "run";          ///< or "freeze"
  std::optional<double> clock_ppm;   ///< of INT's clock; real time
  double session_timeout = 10;       ///< s, for an answer in lockstep
  std::optional<int> viability;      ///< as robot::RobotConfig's
  std::optional<double> seconds;     ///< after which it ends; absent: when it is interrupted
  std::optional<std::filesystem::path> log;
  std::optional<std::filesystem::path> capture;
  PageFlags page;
  DataFlags data;
};

/// Who advances time, and the reason when the flags do not say.
struct Drive {
  scenario::Drive drive = scenario::Drive::kLockstep;
  std::optional<double> pace;
  std::string reason;

  [[nodiscard]] bool is_lockstep() const { return drive == scenario::Drive::kLockstep; }
};

/// Without flags that decide: the wall clock where this host keeps 1 kHz, else lockstep at its
/// pace.
Drive DriveOf(const ServeFlags& flags) {
  if (flags.drive) return {scenario::DriveFromName(*flags.drive), flags.pace, {}};
  if (flags.pace) return {scenario::Drive::kLockstep, flags.pace, {}};
  if (flags.clock_ppm) return {scenario::Drive::kRealtime, {}, {}};
  constexpr Duration kMeasured = std::chrono::milliseconds(500);
  const loop::JitterVerdict verdict = loop::Evaluate(loop::MeasureJitter(kMeasured));
  if (verdict.good) return {scenario::Drive::kRealtime, {}, verdict.text};
  return {scenario::Drive::kLockstep, 1.0, verdict.text};
}

scenario::Scenario LoadWithFlags(const ServeFlags& flags, const Drive& drive, const Host& host) {
  scenario::Scenario scenario = flags.scenario.empty()
                                    ? run::DefaultServed()
                                    : LoadScenario(flags.scenario, flags.data, host);
  ReplaceSite(flags.lab, flags.seed, flags.data, host, scenario);
  if (flags.scene) {
    std::error_code none;
    const bool is_here = std::filesystem::is_regular_file(*flags.scene, none);
    scenario.scene = is_here ? std::filesystem::absolute(*flags.scene) : *flags.scene;
  }
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  scenario.backend = scenario::Scenario().backend;  // the served robot is simulated
  scenario.drive = drive.drive;
  return scenario;
}

bool FreezesWhenIdle(const ServeFlags& flags) {
  if (flags.idle == "run") return false;
  if (flags.idle == "freeze") return true;
  throw InputError(fmt::format("--idle: \"{}\" is neither run nor freeze", flags.idle));
}

/// Whether or not they are there.
bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  return std::filesystem::weakly_canonical(a) == std::filesystem::weakly_canonical(b);
}

bool IsLockstep(const std::string& drive) {
  return scenario::DriveFromName(drive) == scenario::Drive::kLockstep;
}

void RequireServeAgreement(const ServeFlags& flags) {
  RequirePageFlags(flags.page);
  const bool is_realtime = flags.drive && !IsLockstep(*flags.drive);
  const bool is_lockstep = flags.pace || (flags.drive && IsLockstep(*flags.drive));
  RefuseIf(FreezesWhenIdle(flags) && !is_lockstep,
           "--idle freeze goes with --drive lockstep: the wall clock never stands still");
  RefuseIf(flags.clock_ppm && is_lockstep,
           "--clock-ppm goes with --drive realtime: lockstep has one clock");
  RefuseIf(flags.pace && is_realtime, "--pace goes with --drive lockstep: real time has its own");
  if (flags.pace) RequireInRange("--pace", *flags.pace, 0.01, 100);
  if (!(flags.session_timeout >= 0.001 && flags.session_timeout <= 3600)) {
    throw InputError(fmt::format("--session-timeout is {} s; it must lie in [0.001, 3600] s",
                                 flags.session_timeout));
  }
  if (flags.log && flags.capture && IsSameFile(*flags.log, *flags.capture)) {
    throw InputError(fmt::format("--log and --capture both name {}; give each a file of its own",
                                 flags.log->string()));
  }
  RequireDuration(flags.seconds);
}

/// A served robot, from flags to the end.
class Service {
 public:
  Service(const ServeFlags& flags, const Program& program)
      : flags_(flags),
        program_(program),
        files_(FilesOf(flags.data, program)),
        drive_(DriveOf(flags)),
        scenario_(LoadWithFlags(flags, drive_, program.host)) {
    robot::RobotConfig robot = run::MakeServedConfig(scenario_, files_);
    robot.viability = flags_.viability;
    server::ServedRobotSettings settings = MakeSettings();
    robot::MadePlant plant = robot::MakePlant(robot);
    MakeLog();
    page_.emplace(flags_.page.wanted() ? std::optional(PageAt(flags_.page)) : std::nullopt,
                  flags.log ? &records_ : nullptr, ".",
                  [this](std::string_view text) { program_.log->info(text); });
    settings.sink = page_->sink();
    if (flags_.capture) settings.server.capture = &capture_.emplace(*flags_.capture);
    robot_.emplace(robot, std::move(plant), std::move(settings));
    if (flags.log) FilmForLog();
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
  void MakeLog();
  /// Adds scenes to the log, so that pictures of it show hand and objects as they were.
  void FilmForLog();
  /// An operator who takes control at the page leads the robot, unless it is as fast as programs
  /// answer. STOP presses the robot's user stop, and the operator's release lets it go.
  void OpenPage();
  void PressUserStop(bool pressed);
  void ClosePage();
  [[nodiscard]] scenario::RobotData DataOfRobot() const {
    return scenario::LoadRobotData(files_.models, scenario_.robot.model, scenario_.robot.hand);
  }
  void Introduce();
  [[nodiscard]] std::string DescribeTime() const;
  /// How programs made for the robot reach this one.
  [[nodiscard]] std::string DescribeClients() const;
  void Tell(std::string_view line);
  [[nodiscard]] bool Ends();
  /// Says, once each, that log or capture cannot be written any more.
  void TellLosses();
  [[nodiscard]] bool is_unpaced() const { return drive_.is_lockstep() && !drive_.pace; }

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  const Program& program_;
  const run::RunFiles files_;
  const Drive drive_;
  const scenario::Scenario scenario_;
  const InterruptGuard interrupt_;
  std::optional<EventLog> events_;  ///< from Run() to the end
  run::RunRecords records_;         ///< of --log
  std::optional<fci::Capture> capture_;
  bool told_of_log_ = false;
  bool told_of_capture_ = false;
  std::optional<run::OperatorPage> page_;
  std::optional<server::ServedRobot> robot_;
  std::unique_ptr<application::PageOperator>
      operator_;  ///< from before the page is open until it has ended
};

void Service::MakeLog() {
  if (!flags_.log) return;
  // Without a scenario the motion is the client's alone; the log gets one at rest, so that it can
  // be read as any other.
  scenario::Scenario told = scenario_;
  if (flags_.scenario.empty()) {
    const reference::Waypoint stand{.q = told.robot.q_start.value()};
    told.motion.waypoints = {stand, stand};
  }
  records_.Log(*flags_.log, run::InfoOf(told, DataOfRobot()),
               drive_.is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop);
}

void Service::FilmForLog() {
  constexpr Duration kForever = std::chrono::hours(24 * 365);
  const plant::TruthProbe* truth = robot_->truth();
  if (truth == nullptr || !run::RunRecords::CanFilm(*truth)) return;
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
  settings.tell = [this](std::string_view line) { Tell(line); };
  return settings;
}

void Service::Tell(std::string_view line) {
  const Time now = clock_.Now();
  events_->Put(ToSeconds(now.time_since_epoch()), line);
  if (page_) page_->Tell(now, "server", line);
}

void Service::Introduce() {
  std::string text = fmt::format("panda-twin serves {} ({}), drive {}\n", scenario_.robot.model,
                                 robot_->plant_name(), scenario_.drive_name());
  text += fmt::format("  time  {}\n", DescribeTime());
  if (flags_.viability) {
    text += fmt::format("  commands are kept within the limits, up to {} lost in a row\n",
                        *flags_.viability);
  }
  text += fmt::format("  arm   {}\n", fci::ToString(robot_->arm()));
  if (const auto hand = robot_->hand()) text += fmt::format("  hand  {}\n", fci::ToString(*hand));
  text += DescribeClients();
  text += flags_.seconds ? fmt::format("  ends  after {} s, or on Ctrl-C\n", *flags_.seconds)
                         : "  ends  on Ctrl-C\n";
  text += fmt::format("  {}\n", DescribeAccess(flags_.network));
  events_->Put(text);
}

std::string Service::DescribeTime() const {
  std::string text;
  if (!drive_.is_lockstep()) {
    text = "the wall clock: a cycle every 1 ms, answered or not";
  } else if (drive_.pace) {
    text = fmt::format("a cycle when the last state is answered, at most {} times the wall clock",
                       *drive_.pace);
  } else {
    text = "a cycle when the last state is answered, as fast as answers come";
  }
  if (FreezesWhenIdle(flags_)) text += "; none between motions";
  if (!drive_.reason.empty()) {
    text += fmt::format("\n        as this host is {}\n        --drive and --pace decide instead",
                        drive_.reason);
  }
  return text;
}

std::string Service::DescribeClients() const {
  const fci::Endpoint arm = robot_->arm();
  if (arm.port != fci::kArmPort) {
    return "  use   our own programs: libfranka and what is built on it know ports 1337 and 1338 "
           "alone\n";
  }
  const std::string at = arm.address == 0 ? "127.0.0.1" : fci::AddressText(arm.address);
  return fmt::format(
      "  use   libfranka 0.9  franka::Robot robot(\"{0}\", franka::RealtimeConfig::kIgnore);\n"
      "        panda-py       panda_py.Panda(\"{0}\")\n"
      "        libfranka-rs   franka::Robot::new(\"{0}\", RealtimeConfig::Ignore, None)\n"
      "        franka_ros     roslaunch franka_control franka_control.launch robot_ip:={0}\n",
      at);
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
  if (is_unpaced()) {
    settings.watch_only =
        "a robot served in lockstep is as fast as programs answer: serve it with --pace 1 to lead "
        "it";
  } else {
    settings.control = [this](bool wanted) { operator_->Operate(wanted); };
    operator_ = std::make_unique<application::PageOperator>(
        application::PageOperator::Parts{program_.catalogue, files_, page_->channel()}, scenario_,
        robot_->arm(), robot_->hand(),
        [this](Time at, std::string_view kind, std::string_view text) {
          page_->Tell(at, kind, text);
        });
  }
  Say(stdout, page_->Open(settings, scenario_, {.truth = robot_->truth()}));
  std::fflush(stdout);
}

void Service::PressUserStop(bool pressed) {
  try {
    robot_->PressUserStop(pressed);
  } catch (const Error& error) {
    page_->Tell({}, "error", error.what());
  }
}

void Service::ClosePage() {
  page_->Close("the robot is served no more");
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
  robot_->Begin();
  for (const std::string& notice : robot_->notices()) program_.log->info("robot: {}", notice);
  Introduce();
  robot_->Serve([this] { return Ends(); });
  ClosePage();
  robot_->End();
  static_cast<void>(records_.Finish());
  if (capture_) {
    run::FinishCapture(*capture_, [this](std::string_view text) { program_.log->info(text); });
  }
  const std::string warnings = robot_->DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return interrupt_.interrupted() ? kInterrupted : kOk;
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
  Add(serve, "--clock-ppm PPM", flags.clock_ppm, "realtime: drift of the robot's clock");
  Add(serve, "--session-timeout S", flags.session_timeout,
      "lockstep: a motion that is not answered for so long is stopped")
      ->capture_default_str();
  Add(serve, "--viability N", flags.viability,
      "Keep the clients' motions within the limits, whatever up to N commands in a row "
      "are lost; 19 bridges all that no robot aborts for")
      ->check(CLI::Range(0, reference::ViableAxis::kMostLost));
  AddSeed(serve, flags.seed);
  Add(serve, "--log FILE", flags.log, "Write every cycle (MCAP)");
  Add(serve, "--capture FILE", flags.capture, "Keep what goes over the wire (pcapng; see decode)");
  AddPage(serve, flags.page);
  Add(serve, "--for S", flags.seconds, "End after so long");
  AddData(serve, flags.data);
}

}  // namespace twin::cli
