#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/hardware_flags.h"
#include "cli/interrupt.h"
#include "cli/log.h"
#include "cli/ros_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/own_client.h"
#include "twin/application/record_run.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"
#include "twin/run/remote.h"
#include "twin/run/session.h"

namespace twin::cli {
namespace {

constexpr Duration kLook = std::chrono::milliseconds(50);

struct RosCommandFlags {
  std::filesystem::path scenario;
  std::optional<std::string> lab;
  HardwareFlags hardware;
  RosFlags ros;
  std::optional<double> seconds;
  DataFlags data;
};

/// What stands around the arm, what it carries and how it is commanded; no motion.
scenario::Scenario ClientOf(const RosCommandFlags& flags, const Host& host) {
  scenario::Scenario around = run::DefaultServed();
  around.motion.waypoints.assign(2, {.q = *around.robot.q_start});  // a lab wants a motion
  if (!flags.scenario.empty()) around = LoadScenario(flags.scenario, flags.data, host);
  ReplaceSite(flags.lab, {}, flags.data, host, around);
  return application::OwnClientOf(around);
}

/// Whether a real arm may move, and whether robot, network and host are ready for it.
void CheckRobot(const RosCommandFlags& flags, const scenario::Scenario& client,
                const run::RealtimeConfig& settings, const run::RunFiles& files,
                const Program& program, Terminal& terminal) {
  run::Session session(client, program.catalogue, files, nullptr, settings);
  application::RequireAllowed(session.connection().is_twin || flags.hardware.allow,
                              settings.remote);
  const JointVector q = CurrentPositionOf(session, settings.remote);
  const run::Motion first =
      run::MotionOn(client, "ros", control::CommandInterface::kJointPosition,
                    run::StandingFor(q, std::chrono::seconds(1), session.robot().limits));
  const bool is_ready = session.CheckStart(
      first, [&terminal](const run::CheckLine& line) { terminal.Say(application::LineOf(line)); });
  if (!is_ready) throw RobotFault("the robot is not put into ROS 2: not all checks are well");
  if (flags.hardware.allow && !flags.hardware.yes) {
    terminal.ConfirmMotion("from now on ROS nodes move a real arm");
  }
}

int Ros(const RosCommandFlags& flags, const Program& program) {
  RequireDuration(flags.seconds);
  RosFlags ros = flags.ros;
  ros.wanted = true;
  RequireRosFlags(ros);
  const scenario::Scenario client = ClientOf(flags, program.host);
  RequireHardwareFlags(flags.hardware, client);
  const run::RunFiles files = FilesOf(flags.data, program);
  run::RealtimeConfig settings;
  settings.remote =
      run::ParseRemote(*flags.hardware.robot, flags.hardware.robot_time.value_or("auto"));
  {
    Terminal terminal(program.log, program.is_quiet());
    CheckRobot(flags, client, settings, files, program, terminal);
  }
  settings.checks_start = false;  // they are done
  const InterruptGuard interrupt;
  const MonotonicClock clock;
  EventLog events(*program.log_flags);
  const auto seconds = [&clock] { return ToSeconds(clock.Now().time_since_epoch()); };
  const std::unique_ptr<RosBridge> bridge = MakeRosBridge(ros, nullptr);
  events.Put(fmt::format("panda-twin ros: {}\n", *flags.hardware.robot) +
             bridge->OpenRemote(client, settings, files, program.catalogue,
                                [&](std::string_view line) { events.Put(seconds(), line); }));
  while (!interrupt.interrupted() && !(flags.seconds && seconds() >= *flags.seconds)) {
    rt::SleepUntil(clock, clock.Now() + kLook);
  }
  bridge->Close();
  return interrupt.interrupted() ? kInterrupted : kOk;
}

}  // namespace

void AddRosCommand(CLI::App& app, Program& program) {
  const auto [ros, flags] =
      AddCommand(app, program, "ros",
                 "Put a robot on the network, a Panda or a served twin, into ROS 2", &Ros);
  Add(ros, "scenario FILE", flags.scenario,
      "Scenario file: what the arm carries, its limits, and the chain of commands before it");
  AddLab(ros, flags.lab);
  AddRobot(ros, flags.hardware);
  AddRosNames(ros, flags.ros);
  Add(ros, "--for S", flags.seconds, "End after so long");
  AddData(ros, flags.data);
}

}  // namespace twin::cli
