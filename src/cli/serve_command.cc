#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/messages.h"
#include "cli/network.h"
#include "cli/run_page.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "cli/serve_page.h"
#include "cli/wire_capture.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/model/model_library.h"
#include "twin/record/recorder.h"
#include "twin/robot/make_plant.h"
#include "twin/run/run.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/lab.h"
#include "twin/run/remote.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

scenario::Scenario LoadWithFlags(const ServeFlags& flags, const std::filesystem::path& models) {
  scenario::Scenario scenario =
      flags.scenario.empty() ? run::DefaultServed() : scenario::Load(flags.scenario);
  if (flags.lab) scenario::ApplyLab(scenario::FindLab(*flags.lab, models), scenario);
  if (flags.scene) scenario.scene = *flags.scene;
  if (flags.seed) scenario.seed = *flags.seed;
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  scenario.drive = scenario::DriveFromName(flags.drive);
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

void RequireAgreement(const ServeFlags& flags) {
  RequirePageFlags(flags.page);
  const scenario::Drive drive = scenario::DriveFromName(flags.drive);
  if (drive == scenario::Drive::kRemote) {
    throw InputError(
        "--drive remote is for the other end of the wire; serve in realtime or lockstep");
  }
  const bool is_lockstep = drive == scenario::Drive::kLockstep;
  if (FreezesWhenIdle(flags) && !is_lockstep) {
    throw InputError("--idle freeze goes with --drive lockstep: the wall clock never stands still");
  }
  if (flags.clock_ppm && is_lockstep) {
    throw InputError("--clock-ppm goes with --drive realtime: lockstep has one clock");
  }
  if (!(flags.session_timeout >= 0.001 && flags.session_timeout <= 3600)) {
    throw InputError(fmt::format("--session-timeout is {} s; it must lie in [0.001, 3600] s",
                                 flags.session_timeout));
  }
  if (flags.log && flags.capture && IsSameFile(*flags.log, *flags.capture)) {
    throw InputError(fmt::format("--log and --capture both name {}; give each a file of its own",
                                 flags.log->string()));
  }
  if (flags.seconds && !(*flags.seconds > 0)) {
    throw InputError(fmt::format("--for is {} s; it must be above 0", *flags.seconds));
  }
}

server::ServerConfig ServerConfigOf(const ServeFlags& flags, const Host& host) {
  server::ServerConfig config;
  const Listening listening = ListeningOf(flags.network);
  config.address = listening.address;
  config.arm_port = flags.network.arm_port;
  config.hand_port = flags.network.hand_port;
  config.allow = listening.allow;
  try {
    config.model_library = model::ReadModelLibrary(model::FindModelLibrary(host.executable));
  } catch (const EnvironmentError& error) {
    Say(stderr, fmt::format("panda-twin: note: clients get no model library: {}\n", error.what()));
  }
  return config;
}

/// A served robot, from flags to the end.
class Service {
 public:
  Service(const ServeFlags& flags, const Host& host, const run::Catalogue& catalogue)
      : flags_(flags),
        catalogue_(catalogue),
        data_(scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes})),
        files_({data_.models, data_.mesh_package, UsableCache(host), false}),
        scenario_(LoadWithFlags(flags, data_.models)) {
    robot::RobotConfig robot = run::MakeServedConfig(scenario_, files_);
    robot.viability = flags_.viability;
    server::ServedRobotSettings settings = MakeSettings(host);
    robot::MadePlant plant = robot::MakePlant(robot);
    MakeLog();
    page_.emplace(flags_.page, log_ ? &*log_ : nullptr);
    settings.sink = page_->sink();
    if (flags_.capture) settings.server.capture = &capture_.emplace(*flags_.capture);
    robot_.emplace(robot, std::move(plant), std::move(settings));
  }
  ~Service() {
    if (page_) page_->Close();  // it looks at the robot
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  ExitCode Run();

 private:
  /// Short of log and capture.
  [[nodiscard]] server::ServedRobotSettings MakeSettings(const Host& host);
  void MakeLog();
  void Introduce();
  void Tell(std::string_view line);
  [[nodiscard]] bool Ends();
  /// Says, once each, that log or capture cannot be written any more.
  void TellLosses();
  [[nodiscard]] bool is_lockstep() const { return scenario_.drive == scenario::Drive::kLockstep; }

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  const run::Catalogue& catalogue_;
  const scenario::DataDirectory data_;
  const run::RunFiles files_;
  const scenario::Scenario scenario_;
  const InterruptGuard interrupt_;
  std::optional<Messages> messages_;  ///< from Run() to the end
  std::optional<record::Recorder> log_;
  std::optional<fci::Capture> capture_;
  bool told_of_log_ = false;
  bool told_of_capture_ = false;
  std::optional<ServePage> page_;
  std::optional<server::ServedRobot> robot_;
};

void Service::MakeLog() {
  if (!flags_.log) return;
  const scenario::RobotData robot =
      scenario::LoadRobotData(data_.models, scenario_.robot.model, scenario_.robot.hand);
  // Of no scenario nobody knows the motion, which is the client's: the log's one stands, so that
  // the log can be read as any other.
  scenario::Scenario told = scenario_;
  if (flags_.scenario.empty()) {
    const reference::Waypoint stand{.q = told.robot.q_start.value()};
    told.motion.waypoints = {stand, stand};
  }
  log_.emplace(*flags_.log, InfoOf(told, robot),
               is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop);
}

server::ServedRobotSettings Service::MakeSettings(const Host& host) {
  server::ServedRobotSettings settings;
  settings.server = ServerConfigOf(flags_, host);
  if (is_lockstep()) {
    settings.lockstep = {.answer_timeout = FromSeconds(flags_.session_timeout),
                         .freeze_when_idle = FreezesWhenIdle(flags_)};
  }
  settings.tell = [this](std::string_view line) { Tell(line); };
  return settings;
}

void Service::Tell(std::string_view line) {
  const Time now = clock_.Now();
  messages_->Put(fmt::format("{:10.3f} s  {}\n", ToSeconds(now.time_since_epoch()), line));
  if (page_) page_->Tell(now, line);
}

void Service::Introduce() {
  std::string text = fmt::format("panda-twin serves {} ({}), drive {}{}\n", scenario_.robot.model,
                                 robot_->plant_name(), Name(scenario_.drive),
                                 FreezesWhenIdle(flags_) ? ", idle freeze" : "");
  if (flags_.viability) {
    text += fmt::format("  commands are kept within the limits, up to {} lost in a row\n",
                        *flags_.viability);
  }
  text += fmt::format("  arm   {}\n", fci::ToString(robot_->arm()));
  if (const auto hand = robot_->hand()) text += fmt::format("  hand  {}\n", fci::ToString(*hand));
  text += fmt::format("  {}\n", DescribeAccess(flags_.network));
  messages_->Put(std::move(text));
}

void Service::TellLosses() {
  const auto tell = [](bool& told, const std::string& failure) {
    if (told || failure.empty()) return;
    told = true;
    Say(stderr, fmt::format("panda-twin: warning: {}. It goes on without\n", failure));
  };
  if (log_) tell(told_of_log_, log_->Failure());
  if (capture_) tell(told_of_capture_, capture_->Failure());
}

bool Service::Ends() {
  TellLosses();
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

ExitCode Service::Run() {
  interrupt_.ThrowIfInterrupted();
  page_->Open(scenario_,
              scenario::LoadRobotData(data_.models, scenario_.robot.model, scenario_.robot.hand),
              catalogue_, files_, *robot_);
  messages_.emplace();
  robot_->Begin();
  for (const std::string& notice : robot_->notices()) {
    Say(stderr, fmt::format("panda-twin: note: robot: {}\n", notice));
  }
  Introduce();
  robot_->Serve([this] { return Ends(); });
  page_->Close();
  robot_->End();
  if (log_) static_cast<void>(log_->Finish());
  if (capture_) FinishCapture(*capture_);
  const std::string warnings = robot_->DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return interrupt_.interrupted() ? kInterrupted : kOk;
}

}  // namespace

ExitCode ServeCommand(const ServeFlags& flags, const Host& host,
                      const run::Catalogue& catalogue) {
  RequireAgreement(flags);
  return Service(flags, host, catalogue).Run();
}

}  // namespace twin::cli
