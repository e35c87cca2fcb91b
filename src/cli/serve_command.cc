#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/network.h"
#include "cli/say.h"
#include "cli/wire_capture.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/model/model_library.h"
#include "twin/record/recorder.h"
#include "twin/robot/lockstep_robot.h"
#include "twin/robot/make_plant.h"
#include "twin/robot/wall_clock_robot.h"
#include "twin/scenario/assembly.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/server.h"

namespace twin::cli {
namespace {

constexpr JointVector kReady{
    0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966, 0.78539816339744831};

scenario::Scenario LoadWithFlags(const ServeFlags& flags) {
  scenario::Scenario scenario;
  if (flags.scenario.empty()) {
    scenario.name = "serve";
    scenario.robot.q_start = kReady;
  } else {
    scenario = scenario::Load(flags.scenario);
  }
  if (flags.scene) scenario.scene = *flags.scene;
  if (flags.seed) scenario.seed = *flags.seed;
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  scenario.drive = scenario::DriveFromName(flags.drive);
  return scenario;
}

/// The wire itself is the link: it delays and reorders. What a scenario loses is lost all the same.
robot::LinkConfig ServedLink(const robot::LinkConfig& link) {
  robot::LinkConfig served;
  served.state.loss = link.state.loss;
  served.command.loss = link.command.loss;
  served.d_INT = link.d_INT;
  return served;
}

bool FreezesWhenIdle(const ServeFlags& flags) {
  if (flags.idle == "run") return false;
  if (flags.idle == "freeze") return true;
  throw InputError(fmt::format("--idle: \"{}\" is neither run nor freeze", flags.idle));
}

void RequireAgreement(const ServeFlags& flags) {
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

/// A robot and its server, from flags to the end.
class Service {
 public:
  Service(const ServeFlags& flags, const Host& host)
      : flags_(flags), config_(ServerConfigOf(flags, host)), scenario_(LoadWithFlags(flags)) {
    const auto data =
        scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
    data_ = scenario::LoadRobotData(data.models, scenario_.robot.model, scenario_.robot.hand);
    robot::RobotConfig robot = scenario::MakeRobotConfig(
        scenario_, data_, {data.models, data.mesh_package, host.cache, false});
    robot.link = ServedLink(robot.link);
    plant_ = robot::MakePlant(robot);
    MakeLog();
    MakeCapture();
    MakeRobot(robot);
  }

  ExitCode Run();

 private:
  void MakeLog();
  void MakeCapture();
  void MakeRobot(const robot::RobotConfig& robot);
  void Introduce(const server::Server& server) const;
  void Tell(std::string_view line) const;
  [[nodiscard]] bool Ends() const;
  [[nodiscard]] bool is_lockstep() const { return scenario_.drive == scenario::Drive::kLockstep; }

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  server::ServerConfig config_;
  const scenario::Scenario scenario_;
  const InterruptGuard interrupt_;
  scenario::RobotData data_;
  robot::MadePlant plant_;
  std::optional<record::Recorder> log_;
  std::optional<fci::Capture> capture_;
  server::Bell changed_;
  server::UdpPort port_{clock_, config_.address, changed_};
  std::unique_ptr<robot::ThreadedRobot> robot_;
};

void Service::MakeLog() {
  if (!flags_.log) return;
  log_.emplace(*flags_.log,
               record::RunInfo{scenario_.name, scenario_.seed, TWIN_VERSION,
                               std::string(Name(scenario_.drive)), scenario::ToYaml(scenario_),
                               record::RunLimits{data_.limits, data_.cartesian}},
               is_lockstep() ? record::FullRing::kWait : record::FullRing::kDrop);
}

void Service::MakeCapture() {
  if (!flags_.capture) return;
  capture_.emplace(*flags_.capture);
  port_.KeepIn(&*capture_);
  config_.capture = &*capture_;
}

void Service::MakeRobot(const robot::RobotConfig& robot) {
  rt::RecordSink* const sink = log_ ? &*log_ : nullptr;
  if (!is_lockstep()) {
    robot_ = std::make_unique<robot::WallClockRobot>(
        robot, std::move(plant_.plant), port_, clock_,
        rt::ThreadSettings{.name = "twin-int", .fifo_priority = 98}, sink);
    return;
  }
  const robot::LockstepOptions options{FromSeconds(flags_.session_timeout),
                                       FreezesWhenIdle(flags_)};
  robot_ = std::make_unique<robot::LockstepRobot>(
      robot, std::move(plant_.plant), port_, port_, clock_,
      rt::ThreadSettings{.name = "twin-int", .lock_memory = false}, sink, options);
}

void Service::Tell(std::string_view line) const {
  Say(stdout, fmt::format("{:10.3f} s  {}\n", ToSeconds(clock_.Now().time_since_epoch()), line));
  static_cast<void>(std::fflush(stdout));
}

void Service::Introduce(const server::Server& server) const {
  std::string text =
      fmt::format("panda-twin serves {} ({}), drive {}{}\n", scenario_.robot.model, plant_.name,
                  Name(scenario_.drive), FreezesWhenIdle(flags_) ? ", idle freeze" : "");
  text += fmt::format("  arm   {}\n", fci::ToString(server.arm()));
  if (const auto hand = server.hand()) text += fmt::format("  hand  {}\n", fci::ToString(*hand));
  text += fmt::format("  {}\n", DescribeAccess(flags_.network));
  Say(stdout, text);
  static_cast<void>(std::fflush(stdout));
}

bool Service::Ends() const {
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

ExitCode Service::Run() {
  interrupt_.ThrowIfInterrupted();
  server::Server server(std::move(config_), *robot_, port_, changed_, clock_,
                        [this](std::string_view line) { Tell(line); });
  robot_->Begin();
  for (const std::string& notice : robot_->notices()) {
    Say(stderr, fmt::format("panda-twin: note: robot: {}\n", notice));
  }
  Introduce(server);
  server.Run([this] { return Ends(); });
  robot_->End();
  if (log_) static_cast<void>(log_->Finish());
  if (capture_) FinishCapture(*capture_);
  const std::string warnings = plant_.engine != nullptr ? plant_.engine->DescribeWarnings() : "";
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return interrupt_.interrupted() ? kInterrupted : kOk;
}

}  // namespace

ExitCode ServeCommand(const ServeFlags& flags, const Host& host) {
  RequireAgreement(flags);
  return Service(flags, host).Run();
}

}  // namespace twin::cli
