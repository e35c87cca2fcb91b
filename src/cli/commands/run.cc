#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/film_flags.h"
#include "cli/hardware_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/record_cell.h"
#include "twin/application/record_run.h"
#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/run/remote.h"
#include "twin/scenario/cell.h"
#include "twin/scenario/robot_data.h"

namespace twin::cli {
namespace {

struct RunFlags {
  std::filesystem::path scenario;
  std::optional<std::string> lab;  ///< laid over the scenario: a name in models/labs, or a file
  std::optional<std::uint64_t> seed;
  std::filesystem::path out;  ///< empty: out/<scenario's name>
  std::optional<std::string> backend;
  std::optional<std::string> drive;
  std::optional<std::string> device;  ///< of the operator, in place of the scenario's
  HardwareFlags hardware;
  std::string may_touch;            ///< instead of motion.touches
  std::optional<double> clock_ppm;  ///< of INT's clock
  std::optional<int> ext_cpu;       ///< processor of the communication thread; real time
  std::optional<int> int_cpu;       ///< processor of the robot's thread; real time
  std::optional<std::filesystem::path> capture;  ///< backend fci
  std::optional<int> seeds;  ///< of an application: so many, one run each, from the seed on
  int threads = 2;           ///< with seeds
  double least_share = 100;  ///< with seeds: percent that must succeed
  bool strict = false;       ///< an arm that was too far off its path is a failure
  bool no_video = false;
  std::string quality = "draft";
  bool rebuild_cache = false;
  PageFlags page;
  bool wait_for_visitor = false;
  DataFlags data;
};

/// With the device's own defaults: the scenario's parameters are of another one.
void ChooseDevice(const std::string& device, scenario::Scenario& scenario) {
  RefuseIf(!scenario.operator_section, "--device goes with a scenario that has a section operator");
  if (scenario.operator_section->device == device) return;
  scenario.operator_section->device = device;
  scenario.operator_section->parameters.clear();
  scenario.places.device = {};
}

/// @throws InputError when the flags of a remote robot do not go with the scenario.
void RequireRemoteFlags(const RunFlags& flags, const scenario::Scenario& scenario) {
  const bool is_remote = scenario.is_remote();
  if (is_remote && flags.drive) {
    throw InputError(fmt::format(
        "--drive {} contradicts backend fci, whose robot keeps its own time; leave out --drive, or "
        "the backend",
        *flags.drive));
  }
  RequireHardwareFlags(flags.hardware, scenario);
  RefuseIf(!is_remote && flags.capture, "--capture goes with --backend fci");
  RefuseIf(flags.hardware.check_only && flags.page.wanted(),
           "--check-only ends before there is anything to show; leave out --page");
  RefuseIf(is_remote && flags.int_cpu,
           "--int-cpu is of a robot in this process; with backend fci leave it out");
}

/// @throws InputError for flags that do not go with many seeds, or only with them.
void RequireSeedsFlags(const RunFlags& flags, const scenario::Scenario& scenario) {
  RefuseIf(!scenario.application, "--seeds goes with an application; this scenario has a motion");
  RefuseIf(!scenario.is_lockstep(),
           "--seeds goes with lockstep: on the wall clock no seed repeats");
  RefuseIf(flags.hardware.max_speed.has_value(), "--seeds and --max-speed do not go together");
  if (!(flags.least_share >= 0 && flags.least_share <= 100)) {
    throw InputError(
        fmt::format("--least-share is {} %; it must lie in [0, 100] %", flags.least_share));
  }
}

/// @throws InputError for flags that do not go together, with this scenario.
void RequireAgreement(const RunFlags& flags, const scenario::Scenario& scenario) {
  RequirePageFlags(flags.page);
  RefuseIf(flags.wait_for_visitor && !flags.page.wanted(), "--wait-for-visitor goes with --page");
  RefuseIf(flags.seeds && flags.page.wanted(),
           "--page shows one run; leave out --seeds, or the page");
  RefuseIf(flags.seeds && flags.strict, "--strict judges one run; leave out --seeds, or --strict");
  if (flags.seeds) return RequireSeedsFlags(flags, scenario);
  RefuseIf(flags.hardware.max_speed && scenario.application,
           "--max-speed goes with a motion; an application makes its own: see its parameters");
}

/// @throws EnvironmentError when a program that the results need is missing.
void RequirePrograms(const RunFlags& flags, const scenario::Scenario& scenario,
                     const application::RunOptions& options, const Host& host) {
  if (flags.seeds) return RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox");
  const application::NeededPrograms needed = application::ProgramsFor(scenario, options);
  if (needed.ffmpeg) {
    RequireProgram("ffmpeg", host.path, "apt-get install ffmpeg, or run with --no-video");
  }
  if (needed.gnuplot) {
    RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox, or say record: false");
  }
}

application::RunOptions OptionsOf(const RunFlags& flags, const scenario::Scenario& scenario) {
  const std::string name = scenario.name + (flags.seeds ? "_seeds" : "");
  application::RunOptions options{
      .scenario = flags.scenario,
      .out = flags.out.empty() ? std::filesystem::path("out") / name : flags.out,
      .site = flags.lab ? "lab " + *flags.lab : "the scenario's own",
      .makes_video = !flags.no_video,
      .has_fine_pictures = IsFine(flags.quality),
      .strict = flags.strict,
      .hardware = {},
      .capture = flags.capture};
  if (flags.page.wanted()) options.page = PageAt(flags.page);
  options.waits_for_visitor = flags.wait_for_visitor;
  options.settings.threads.robot.cpu = flags.int_cpu;
  options.settings.threads.communication.cpu = flags.ext_cpu;
  if (const auto& robot = flags.hardware.robot) {
    options.settings.remote = run::ParseRemote(*robot, flags.hardware.robot_time.value_or("auto"));
  }
  return options;
}

/// The command that runs the same motion in the twin.
std::string RehearsalCommand(const RunFlags& flags) {
  std::string command = fmt::format("panda-twin run {}", InShell(flags.scenario.string()));
  const auto add = [&command](std::string_view flag, const auto& value) {
    if (value) command += fmt::format(" {} {}", flag, *value);
  };
  if (flags.lab) command += " --lab " + InShell(*flags.lab);
  add("--seed", flags.seed);
  add("--device", flags.device);
  add("--clock-ppm", flags.clock_ppm);
  if (!flags.may_touch.empty()) {
    command += " --no-collision-check " + InShell(flags.may_touch);
  }
  command += DataInShell(flags.data);
  if (!flags.backend) command += " --backend mujoco";  // the scenario itself says fci
  return command;
}

/// The command that brings a remote arm to the scenario's start.
std::string CommandToStart(const RunFlags& flags) {
  const HardwareFlags& there = flags.hardware;
  if (!there.robot) return {};
  std::string command =
      fmt::format("panda-twin move-to start-of {}", InShell(flags.scenario.string()));
  if (flags.lab) command += " --lab " + InShell(*flags.lab);
  command += DataInShell(flags.data);
  command += " --backend fci --robot " + *there.robot;
  if (there.robot_time) command += " --robot-time " + *there.robot_time;
  if (there.allow) command += " --allow-hardware";
  return command;
}

void RequireThreads(const RunFlags& flags, const scenario::Scenario& scenario) {
  RefuseIf(scenario.is_lockstep() && (flags.ext_cpu || flags.int_cpu),
           "--ext-cpu and --int-cpu go with --drive realtime: lockstep has one thread");
}

/// Of all robots. @throws InputError where one does not go with it.
void ChooseDrive(scenario::Drive drive, scenario::Cell& cell) {
  cell.common.drive = drive;
  for (scenario::CellRobot& robot : cell.robots) {
    robot.scenario.drive = drive;
    robot.scenario.Validate();
  }
}

/// The scenario with what the command line says in its place, validated.
/// @throws InputError as scenario::Load, and for flags that do not go together.
scenario::Scenario LoadWithFlags(const RunFlags& flags, const Host& host) {
  scenario::Scenario scenario = LoadScenario(flags.scenario, flags.data, host);
  ReplaceSite(flags.lab, flags.seed, flags.data, host, scenario);
  if (flags.backend) scenario.backend = *flags.backend;
  if (flags.drive) scenario.drive = scenario::DriveFromName(*flags.drive);
  if (flags.device) ChooseDevice(*flags.device, scenario);
  RequireRemoteFlags(flags, scenario);
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  if (!flags.may_touch.empty()) scenario.motion.touches = flags.may_touch;
  RequireThreads(flags, scenario);
  scenario.Validate();
  return scenario;
}

/// @throws InputError for flags of one robot.
void RequireCellFlags(const RunFlags& flags) {
  RefuseIf(
      flags.lab || flags.backend || flags.device || flags.clock_ppm || flags.capture ||
          flags.seeds || !flags.may_touch.empty() || flags.hardware.robot || flags.hardware.allow ||
          flags.hardware.check_only || flags.hardware.max_speed || flags.page.wanted() ||
          flags.wait_for_visitor,
      "this scenario has several robots, which take of the flags only --seed, --drive, "
      "--ext-cpu, --int-cpu, --out, --strict, --no-video, --quality, --rebuild-cache, --data and "
      "--meshes");
}

/// A scenario of several robots. @param file  its own.
int RunCell(const std::filesystem::path& file, const RunFlags& flags, const Program& program) {
  RequireCellFlags(flags);
  scenario::Cell cell = scenario::LoadCell(file, flags.seed);
  if (flags.drive) ChooseDrive(scenario::DriveFromName(*flags.drive), cell);
  RequireThreads(flags, cell.common);
  application::RunOptions options = OptionsOf(flags, cell.common);
  RequirePrograms(flags, cell.common, options, program.host);
  Terminal terminal(program.log, program.is_quiet());
  run::RunFiles files = FilesOf(flags.data, program);
  files.rebuild_cache = flags.rebuild_cache;
  application::RecordCell({cell, options, files, program.catalogue, terminal});
  return kOk;
}

int Run(const RunFlags& flags, const Program& program) {
  const std::filesystem::path file = ScenarioFile(flags.scenario, flags.data, program.host);
  if (scenario::HasRobots(file)) return RunCell(file, flags, program);
  scenario::Scenario scenario = LoadWithFlags(flags, program.host);
  RequireAgreement(flags, scenario);
  application::RunOptions options = OptionsOf(flags, scenario);
  RequirePrograms(flags, scenario, options, program.host);
  Terminal terminal(program.log, program.is_quiet());
  run::RunFiles files = FilesOf(flags.data, program);
  files.rebuild_cache = flags.rebuild_cache;
  const application::RunInputs inputs{scenario, options, files, program.catalogue, terminal};
  if (flags.seeds) {
    application::RecordSeeds(inputs, {*flags.seeds, flags.threads, flags.least_share});
    return kOk;
  }
  const CalendarClock calendar;
  const run::RunHistory history(program.host.state, calendar);
  options.hardware =
      HardwareOf(flags.hardware, scenario, files, RehearsalCommand(flags), history, terminal);
  options.hardware.to_start = CommandToStart(flags);
  if (const double speed = options.hardware.rehearsal.max_speed; speed != 1) {
    run::SlowDown(scenario,
                  scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand),
                  speed);
  }
  application::RecordRun(inputs);
  return kOk;
}

}  // namespace

void AddRun(CLI::App& app, Program& program) {
  const auto [run, flags] =
      AddCommand(app, program, "run", "Run a scenario and write log, plots and video", &Run);
  Add(run, "scenario FILE", flags.scenario, "Scenario file")->required();
  AddSeed(run, flags.seed);
  AddLab(run, flags.lab);
  AddPage(run, flags.page);
  run.add_flag("--wait-for-visitor", flags.wait_for_visitor,
               "Begin when the page is first opened in a browser");
  Add(run, "--out DIR", flags.out, "Folder of results (default: out/<name of the scenario>)");
  Add(run, "--backend", flags.backend,
      "Backend, instead of the scenario's: mujoco, or fci (a robot on the network)");
  Add(run, "--drive", flags.drive, "Who advances time: lockstep or realtime; not with fci");
  Add(run, "--device", flags.device,
      "What the operator holds, instead of the scenario's: page, evdev, network, ...");
  AddRobot(run, flags.hardware);
  AddRehearsal(run, flags.hardware);
  Add(run, "--capture FILE", flags.capture,
      "fci: keep what goes over the wire (pcapng; see decode)");
  AddMayTouch(run, flags.may_touch);
  Add(run, "--clock-ppm PPM", flags.clock_ppm,
      "Drift of the robot's clock, instead of the scenario's");
  Add(run, "--ext-cpu N", flags.ext_cpu, "realtime, fci: processor of the communication thread");
  Add(run, "--int-cpu N", flags.int_cpu, "realtime: processor of the robot's thread");
  Add(run, "--seeds N", flags.seeds,
      "An application: carry it out for N seeds from --seed on, and tell how many succeed");
  Add(run, "--threads N", flags.threads, "With --seeds: so many at once")->capture_default_str();
  Add(run, "--least-share PERCENT", flags.least_share,
      "With --seeds: fail when fewer percent succeed")
      ->capture_default_str();
  run.add_flag("--strict", flags.strict,
               "Exit code 1, not only a warning, when the arm was further off its path than "
               "max_deviation");
  run.add_flag("--no-video", flags.no_video, "Make no video and no contact sheet");
  AddQuality(run, flags.quality);
  run.add_flag("--rebuild-cache", flags.rebuild_cache, "Compile the robot's model anew");
  AddData(run, flags.data);
}

}  // namespace twin::cli
