#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/robot_service.h"
#include "cli/ros_flags.h"
#include "cli/serve_cell.h"
#include "cli/serve_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/reference/viable_axis.h"
#include "twin/scenario/cell.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

/// Serves one robot, until it is interrupted or the flags' time is over.
int ServeOne(const ServeFlags& flags, const Program& program) {
  const MonotonicClock clock;
  const InterruptGuard interrupt;
  std::optional<EventLog> events;
  RobotService service(flags, HostOf(flags, program), program,
                       [&events](double at_s, std::string_view line) { events->Put(at_s, line); });
  application::ServedSession& session = service.session();
  interrupt.ThrowIfInterrupted();
  events.emplace(*program.log_flags);
  if (const std::string page = service.Open(); !page.empty()) events->Put(page);
  session.StartLog();
  session.robot().Begin();
  for (const std::string& notice : session.robot().notices()) {
    program.log->info("robot: {}", notice);
  }
  events->Put(service.Introduce());
  session.robot().Serve([&] {
    for (const std::string& loss : session.NewLosses()) program.log->warn("{}", loss);
    if (interrupt.interrupted()) return true;
    return flags.seconds && clock.Now().time_since_epoch() >= FromSeconds(*flags.seconds);
  });
  const bool is_interrupted = interrupt.interrupted();
  if (session.out() != nullptr)
    interrupt.Rearm();  // a second one must not kill what closes the log
  service.Close();
  service.End();
  events.reset();  // the terminal writes to standard output
  Terminal terminal(program.log, program.is_quiet());
  service.WriteResults(terminal);
  const std::string warnings = session.robot().DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return is_interrupted ? kInterrupted : kOk;
}

int Serve(const ServeFlags& flags, const Program& program) {
  RequireServeAgreement(flags);
  if (!flags.scenario.empty()) {
    const std::filesystem::path file = ScenarioFile(flags.scenario, flags.data, program.host);
    if (scenario::HasRobots(file)) return ServeCell(file, flags, program);
  }
  return ServeOne(flags, program);
}

}  // namespace

void AddServe(CLI::App& app, Program& program) {
  const auto [serve, flags] =
      AddCommand(app, program, "serve",
                 "Serve a robot to programs made for it (FCI protocol 5, an FR3: 10)", &Serve);
  Add(serve, "scenario FILE", flags.scenario, "Scenario file (default: the ready pose, no scene)");
  AddLab(serve, flags.lab);
  Add(serve, "--model NAME", flags.model,
      "Arm: panda or fr3, or another folder below models/robots (default: the scenario's, or panda)");
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
  Add(serve, "--log-split TIME|SIZE", flags.log_split,
      "Split the log into FILE_0001, FILE_0002 ..., a new one after so long (1h, robot's time) or so "
      "much (512MiB)");
  Add(serve, "--log-keep N", flags.log_keep,
      "With --log-split: keep the newest N ended files and remove older ones (default: keep all)");
  Add(serve, "--capture FILE", flags.capture, "Keep what goes over the wire (pcapng; see decode)");
  Add(serve, "--control FILE", flags.control,
      "Let programs on this machine pause, step and stop the robot over this Unix socket (see ctl); "
      "of several robots each has its own: FILE.left");
  AddPage(serve, flags.page);
  AddRos(serve, flags.ros);
  Add(serve, "--for S", flags.seconds, "End after so long");
  AddData(serve, flags.data);
}

}  // namespace twin::cli
