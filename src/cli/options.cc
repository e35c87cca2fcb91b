#include "cli/options.h"

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "cli/data_options.h"
#include "cli/devices_options.h"
#include "cli/render_options.h"
#include "cli/video_options.h"
#include "twin/reference/viable_axis.h"

namespace twin::cli {
namespace {

constexpr const char* kFooter = R"(Start here:
  panda-twin check                                       does this host have all it takes, and keep 1 kHz?
  panda-twin run models/scenarios/canonical.yaml         the main example; results in out/canonical
  panda-twin run SCENARIO.yaml --seed 7 --out /tmp/a     other random numbers, another folder
  panda-twin run SCENARIO.yaml --lab b                   at another site: other masses, friction, tilt, delays
  panda-twin run models/applications/pick_and_place.yaml a whole task: steps, retries, what is demanded, report.html
  panda-twin run APPLICATION.yaml --seeds 100            the same for a hundred seeds: how many succeed, and why not
  panda-twin run SCENARIO.yaml --drive realtime          on the wall clock, threads at real-time priority
  panda-twin run SCENARIO.yaml --page                    watch it in a browser; the address is printed
  panda-twin run models/applications/teleoperation.yaml --device page --page   lead it from there
  panda-twin serve                                       a Panda for libfranka programs, at 127.0.0.1
  panda-twin proxy --robot HOST --link FILE.yaml         a wire with faults, before a robot or a twin
  panda-twin experiment all                              the paper's tables and figures, beside ours
  panda-twin render out/canonical --out slow.mp4 --speed 0.25   any recorded run as a video, any camera; two side by side
  panda-twin video check                                 do the runs look as they were approved?
  panda-twin validate my.yaml                            is my scenario sound? (no run)
  panda-twin run SCENARIO.yaml --backend fci --robot HOST --allow-hardware --max-speed 0.1   on a robot, slowly
  panda-twin export out/canonical/run.mcap               the log as CSV tables
  panda-twin devices                                     what is plugged in to lead the robot by hand?
  panda-twin explain out/canonical                       why did the run abort? value, limit, cause, cure

A scenario is a YAML file that describes a run: robot, link, controller, motion or application. Start from one in
models/scenarios; every quantity in it carries its unit, and what is wrong is named by file and line.

A run writes run.mcap (every cycle; opens in Foxglove), scenario.yaml (the scenario, complete),
plots/*.svg, video.mp4, contact_sheet.png, summary.json (in lockstep it repeats with the seed, byte by byte) and
timing.json (wall-clock figures, which do not); an application also report.html and snapshots/*.png. Files are called *.partial until they are whole.

Exit codes:
  0 ok   1 the run aborted, a check failed (with --strict the deviation's too), or no plan was found   2 usage   3 bad input
  4 environment   130 interrupted (the motion was stopped and the log completed))";

constexpr const char* kRunFooter =
    R"(The folder of results is made when missing. Results of an earlier run in it are removed when the motion
starts, never before all input has been found good; other files there stay. A run that its robot refuses before that, or
that finds no plan, leaves a summary.json that says so. Of a log that could not be written to its end (a full disk),
run.mcap.partial stays, and can be read. ffmpeg and gnuplot may do nothing for a minute, and are then ended.
A scenario that names a controller.library executes its code, with your rights.)";

constexpr const char* kValidateFooter =
    R"(Checks all that run checks, and moves nothing. A scenario may name a shared library (controller.library), whose
code run executes with your rights: look at what you were given before you run it. validate does not load it unless
--load is given; its parameters are then checked too.)";

constexpr const char* kServeFooter =
    R"(Of a scenario, robot, plant, scene, perturbations, panel events, the losses of its link and the start count;
its motion is the client's affair. A push with `motion: N` waits for the N-th motion of whoever connects. Of --lab, plant
and losses count; its delays have no effect, since socket and client are real (panda-twin proxy delays what passes).
drive lockstep: the next state is sent when the client has answered the last, so that nothing depends on how fast
either is; --idle freeze: physics stands still between motions, too.
--log and --capture replace a log and a capture, and no other file; each is FILE.partial until the end. When one cannot
be written any more, a warning says so at once, the robot is served on, and the exit code is 4.
Exit codes: 0 after --for, 130 when interrupted, others as ever.)";

constexpr const char* kProxyFooter =
    R"(TCP passes as it is; of datagrams, states are those from the robot, commands those to it. What --link and the
other flags take is what a scenario's section link takes (models/scenarios/README.md), so
  --state-delay "{log_normal: {median: 60 us, sigma: 0.3}}" --command-loss "{scripted: [{at: 2 s, count: 25}]}"
d_INT is the robot's, and has no effect here. The first datagram of a session has number 0 in its direction; its fate
follows from the faults, the seed and that number. At the end: how many came, went on, were delayed, and so on.)";

constexpr const char* kExperimentFooter =
    R"(In lockstep the same seed gives the same report, byte by byte; in realtime it tells what this machine makes of
the loops, and takes about 7 minutes. Writes report.html, one page that needs no other file, findings.json, every
figure with its verdict (predicted, calibrated, not reproduced), and csv/*.csv, the points of every curve. The delays of the three loops are in bare.yaml, synchronous.yaml and asynchronous.yaml of
models/experiments; --calibration takes a folder with yours.
`timings --client CMD` serves a robot on the wall clock, runs any program made for it until it ends, and tells its
d_EXT on the wire, unserved cycles, losses in a row and how far they are from the 20 that end a motion (of one that
does not end by itself after --for S), so
  panda-twin experiment timings --client "./communication_test 127.0.0.1"
Exit code 1: an experiment could not be done, or missed what is demanded of it for no known reason; each is named in a line.)";

constexpr const char* kExplainFooter =
    R"(Of a run that an error ended: what happened, in which cycle, which joint or axis, value and limit, how the
value was computed, what became of the last commands, the usual cause, and what helps; and explain.html,
one page with the last 50 cycles plotted. Of any other run: how close it came to each limit.)";

/// CLI11 would take -1 as a large number, clamp what is too large, and read 010 as octal.
std::uint64_t ParseSeed(const std::string& text) {
  std::uint64_t seed = 0;
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, seed);
  if (error == std::errc() && parsed == end) return seed;
  throw CLI::ValidationError("--seed",
                             fmt::format("\"{}\" is not a whole number from 0 to {}", text,
                                         std::numeric_limits<std::uint64_t>::max()));
}

void AddSeed(CLI::App& app, std::optional<std::uint64_t>& seed,
             const char* what = "Seed of all random numbers, instead of the scenario's") {
  app.add_option_function<std::string>(
         "--seed", [&seed](const std::string& text) { seed = ParseSeed(text); }, what)
      ->type_name("UINT");
}

void AddLab(CLI::App& app, std::optional<std::string>& lab) {
  app.add_option("--lab", lab, "Site laid over the scenario: a, b (models/labs), or a file")
      ->type_name("NAME|FILE");
}

/// The flags of a robot at the other end of a wire.
void AddRemote(CLI::App& app, RunFlags& flags) {
  app.add_option("--robot", flags.robot, "fci: the robot, or the twin that is served")
      ->type_name("HOST[:PORT]");
  app.add_option("--robot-time", flags.robot_time,
                 "fci: wall (hardware, or a twin in real time; the default) or states (a twin "
                 "served in lockstep)")
      ->type_name("wall|states");
  app.add_option("--capture", flags.capture,
                 "fci: keep what goes over the wire (pcapng; see decode)")
      ->type_name("FILE");
  app.add_flag("--allow-hardware", flags.allow_hardware,
               "fci: a real arm may move; needed wherever no twin says that it is one");
  app.add_option("--max-speed", flags.max_speed,
                 "Share of the scenario's speed, in (0, 1]: all times are divided by it")
      ->type_name("F");
}

/// Takes its port behind a '=' only: what follows it is the scenario.
void AddPage(CLI::App& app, PageFlags& flags) {
  app.add_flag("--page{8080}", flags.port,
               "Show it in a browser: --page, or --page=PORT (0: any free one); the address is "
               "printed")
      ->type_name("PORT");
  app.add_option("--page-bind", flags.bind, "Address of this machine to serve the page at")
      ->capture_default_str()
      ->type_name("ADDRESS");
  app.add_option("--page-allow", flags.allow, "Network that may open the page, beside this machine")
      ->type_name("ADDRESS/BITS");
}

CLI::App* AddRun(CLI::App& app, RunFlags& flags) {
  CLI::App* run = app.add_subcommand("run", "Run a scenario and write log, plots and video");
  run->add_option("scenario", flags.scenario, "Scenario file")->required()->type_name("FILE");
  AddSeed(*run, flags.seed);
  AddLab(*run, flags.lab);
  AddPage(*run, flags.page);
  run->add_option("--out", flags.out, "Folder of results (default: out/<name of the scenario>)")
      ->type_name("DIR");
  run->add_option("--backend", flags.backend,
                  "Backend, instead of the scenario's: mujoco, or fci (a robot on the network)");
  run->add_option("--drive", flags.drive, "Who advances time: lockstep, realtime; remote with fci");
  run->add_option("--device", flags.device,
                  "What the operator holds, instead of the scenario's: page, evdev, network, ...");
  AddRemote(*run, flags);
  run->add_option("--clock-ppm", flags.clock_ppm,
                  "Drift of the robot's clock, instead of the scenario's")
      ->type_name("PPM");
  run->add_option("--ext-cpu", flags.ext_cpu,
                  "realtime, fci: processor of the communication thread")
      ->type_name("N");
  run->add_option("--int-cpu", flags.int_cpu, "realtime: processor of the robot's thread")
      ->type_name("N");
  run->add_option(
         "--seeds", flags.seeds,
         "An application: carry it out for N seeds from --seed on, and tell how many succeed")
      ->type_name("N");
  run->add_option("--threads", flags.threads, "With --seeds: so many at once")
      ->type_name("N")
      ->capture_default_str();
  run->add_option("--least-share", flags.least_share,
                  "With --seeds: fail when fewer percent succeed")
      ->type_name("PERCENT")
      ->capture_default_str();
  run->add_flag("--strict", flags.strict,
                "Exit code 1, not only a warning, when the arm was further off its path than "
                "max_deviation");
  run->add_flag("--no-video", flags.no_video, "Make no video and no contact sheet");
  run->add_flag("--rebuild-cache", flags.rebuild_cache, "Compile the robot's model anew");
  run->add_flag("--quiet", flags.quiet, "No progress and no summary; errors only");
  AddDataFlags(*run, flags.data);
  run->footer(kRunFooter);
  return run;
}

void AddNetwork(CLI::App& app, NetworkFlags& flags) {
  app.add_option("--bind", flags.bind, "Address to listen at")->capture_default_str();
  app.add_option("--allow", flags.allow, "Network that may connect, such as 192.168.1.0/24")
      ->type_name("CIDR");
  app.add_option("--port", flags.arm_port, "TCP port of the arm; 0: any")->capture_default_str();
  app.add_option("--hand-port", flags.hand_port, "TCP port of the hand; 0: any")
      ->capture_default_str();
}

CLI::App* AddServe(CLI::App& app, ServeFlags& flags) {
  CLI::App* serve =
      app.add_subcommand("serve", "Serve a robot to programs made for it (FCI protocol 5)");
  serve->add_option("scenario", flags.scenario, "Scenario file (default: the ready pose, no scene)")
      ->type_name("FILE");
  AddLab(*serve, flags.lab);
  serve->add_option("--scene", flags.scene, "World around the robot (MJCF in the models folder)")
      ->type_name("FILE");
  AddNetwork(*serve, flags.network);
  serve->add_option("--drive", flags.drive, "Who advances time: realtime or lockstep")
      ->capture_default_str();
  serve->add_option("--idle", flags.idle, "lockstep: time between motions: run or freeze")
      ->capture_default_str();
  serve->add_option("--clock-ppm", flags.clock_ppm, "realtime: drift of the robot's clock")
      ->type_name("PPM");
  serve
      ->add_option("--session-timeout", flags.session_timeout,
                   "lockstep: a motion that is not answered for so long is stopped")
      ->capture_default_str()
      ->type_name("S");
  serve
      ->add_option(
          "--viability", flags.viability,
          "Keep the clients' motions within the limits, whatever up to N commands in a row "
          "are lost; 19 bridges all that no robot aborts for")
      ->type_name("N")
      ->check(CLI::Range(0, reference::ViableAxis::kMostLost));
  AddSeed(*serve, flags.seed);
  serve->add_option("--log", flags.log, "Write every cycle (MCAP)")->type_name("FILE");
  serve->add_option("--capture", flags.capture, "Keep what goes over the wire (pcapng; see decode)")
      ->type_name("FILE");
  AddPage(*serve, flags.page);
  serve->add_option("--for", flags.seconds, "End after so long")->type_name("S");
  AddDataFlags(*serve, flags.data);
  serve->footer(kServeFooter);
  return serve;
}

/// A key of a scenario's link, as a flag: state_delay, --state-delay.
struct FaultFlag {
  std::string_view key;
  const char* flag;
  const char* text;
};
constexpr FaultFlag kFaultFlags[] = {
    {"state_delay", "--state-delay", "How long states take, such as \"200 us\""},
    {"state_loss", "--state-loss", "Which states never arrive, such as \"0.1 %\""},
    {"state_duplication", "--state-duplication", "States that arrive a second time"},
    {"state_reordering", "--state-reordering", "States that are overtaken"},
    {"command_delay", "--command-delay", "How long commands take"},
    {"command_loss", "--command-loss", "Which commands never arrive"},
    {"command_duplication", "--command-duplication", "Commands that arrive a second time"},
    {"command_reordering", "--command-reordering", "Commands that are overtaken"}};

CLI::App* AddProxy(CLI::App& app, ProxyFlags& flags) {
  CLI::App* proxy =
      app.add_subcommand("proxy", "Pass a robot's wire on, with delays and losses by a seed");
  proxy->add_option("--robot", flags.robot, "The robot, or the twin that is served")
      ->required()
      ->type_name("HOST[:PORT]");
  AddNetwork(*proxy, flags.network);
  proxy
      ->add_option("--link", flags.link,
                   "All faults: a scenario, or a file with its section link only")
      ->type_name("FILE");
  for (const FaultFlag& fault : kFaultFlags) {
    proxy
        ->add_option_function<std::string>(
            fault.flag,
            [&flags, key = fault.key](const std::string& value) {
              flags.faults.emplace_back(key, value);
            },
            fault.text)
        ->type_name("YAML");
  }
  proxy
      ->add_option_function<std::string>(
          "--seed", [&flags](const std::string& text) { flags.seed = ParseSeed(text); },
          "Seed of the faults (default: 1)")
      ->type_name("UINT");
  proxy->add_option("--cpu", flags.cpu, "Processor of the threads that relay datagrams")
      ->type_name("N");
  proxy->add_option("--for", flags.seconds, "End after so long")->type_name("S");
  proxy->footer(kProxyFooter);
  return proxy;
}

CLI::App* AddExperiment(CLI::App& app, ExperimentFlags& flags) {
  CLI::App* experiment =
      app.add_subcommand("experiment", "Reproduce the paper's tables and figures, as a report");
  CLI::Option* ids = experiment->add_option("experiments", flags.ids, "Which (see --list), or all");
  ids->type_name("ID...");
  experiment->add_flag("--list", flags.list, "Say which there are")->excludes(ids);
  AddSeed(*experiment, flags.seed, "Seed of all random numbers (default: 1)");
  experiment
      ->add_option("--seeds", flags.seeds, "Runs of what is averaged (default: 20; realtime: 5)")
      ->type_name("N");
  experiment
      ->add_option("--drive", flags.drive,
                   "lockstep, or realtime: on the wall clock, over UDP against a robot served here")
      ->capture_default_str();
  experiment
      ->add_option("--out", flags.out,
                   "Folder of the report (default: out/experiments, or out/experiments_realtime)")
      ->type_name("DIR");
  experiment
      ->add_option("--calibration", flags.calibration,
                   "Folder of the experiments' scenarios, instead of models/experiments")
      ->type_name("DIR");
  CLI::Option* client =
      experiment
          ->add_option("--client", flags.client,
                       "timings of a program of yours, which finds a robot at 127.0.0.1")
          ->type_name("\"CMD\"");
  experiment
      ->add_option("--port", flags.port, "client: TCP port of the arm; the hand's is the next")
      ->capture_default_str()
      ->check(CLI::Range(1, 65534))
      ->needs(client);
  experiment->add_option("--for", flags.seconds, "client: end it after so long, and report")
      ->check(CLI::Range(0.1, 3600.0))
      ->type_name("S")
      ->needs(client);
  experiment->add_flag("--quiet", flags.quiet, "No progress; errors and what was missed only");
  AddDataFlags(*experiment, flags.data);
  experiment->final_callback([&flags] {
    if (flags.ids.empty() && !flags.list) throw CLI::RequiredError("experiments or --list");
  });
  experiment->footer(kExperimentFooter);
  return experiment;
}

CLI::App* AddValidate(CLI::App& app, ValidateFlags& flags) {
  CLI::App* validate = app.add_subcommand("validate", "Check a scenario without running it");
  validate->add_option("scenario", flags.scenario, "Scenario file")->required()->type_name("FILE");
  validate->add_flag("--load", flags.load,
                     "Load the scenario's controller.library too, which runs code of it");
  AddDataFlags(*validate, flags.data);
  validate->footer(kValidateFooter);
  return validate;
}

CLI::App* AddCheck(CLI::App& app, CheckFlags& flags) {
  CLI::App* check = app.add_subcommand("check", "Say what this host offers, and what is missing");
  check
      ->add_option("--seconds", flags.seconds, "Length of each of the two measurements (0.5 to 60)")
      ->capture_default_str()
      ->type_name("S");
  AddDataFlags(*check, flags.data);
  return check;
}

CLI::App* AddExport(CLI::App& app, ExportFlags& flags) {
  CLI::App* exported = app.add_subcommand("export", "Write a log as CSV tables");
  exported->add_option("log", flags.log, "Log of a run (run.mcap)")->required()->type_name("FILE");
  exported->add_option("--out", flags.out, "Folder of the tables (default: csv beside the log)")
      ->type_name("DIR");
  return exported;
}

CLI::App* AddExplain(CLI::App& app, ExplainFlags& flags) {
  CLI::App* explain = app.add_subcommand("explain", "Say how a run ended, and why");
  CLI::Option* log =
      explain->add_option("log", flags.log, "Log of a run, or its folder of results");
  log->type_name("FILE|DIR");
  explain->add_option("--out", flags.out, "Folder of the page (default: beside the log)")
      ->type_name("DIR");
  CLI::Option* errors = explain->add_flag("--errors", flags.errors,
                                          "Print all errors of the robot's controller (Markdown)");
  errors->excludes(log);
  explain->add_flag("--modes", flags.modes, "Print what the robot grants in which mode (Markdown)")
      ->excludes(log)
      ->excludes(errors);
  explain->final_callback([&flags] {
    if (flags.log.empty() && !flags.errors && !flags.modes) {
      throw CLI::RequiredError("log, --errors or --modes");
    }
  });
  explain->footer(kExplainFooter);
  return explain;
}

CLI::App* AddDecode(CLI::App& app, DecodeFlags& flags) {
  CLI::App* decode = app.add_subcommand("decode", "Print a capture of the wire, field by field");
  decode
      ->add_option("capture", flags.capture,
                   "What --capture or Wireshark wrote (pcapng); what tcpdump -w wrote, after "
                   "editcap -F pcapng IN OUT")
      ->required()
      ->type_name("FILE");
  decode->add_flag("--brief", flags.brief, "A line for each message, no fields");
  decode->add_option("--port", flags.arm_port, "TCP port of the arm")->capture_default_str();
  decode->add_option("--hand-port", flags.hand_port, "TCP port of the hand")->capture_default_str();
  return decode;
}

}  // namespace

Commands AddCommands(CLI::App& app, Flags& flags) {
  const Commands commands{.run = AddRun(app, flags.run),
                          .serve = AddServe(app, flags.serve),
                          .proxy = AddProxy(app, flags.proxy),
                          .render = AddRender(app, flags.render),
                          .video = AddVideo(app, flags.video),
                          .experiment = AddExperiment(app, flags.experiment),
                          .validate = AddValidate(app, flags.validate),
                          .check = AddCheck(app, flags.check),
                          .explain = AddExplain(app, flags.explain),
                          .decode = AddDecode(app, flags.decode),
                          .devices = AddDevices(app, flags.devices),
                          .exported = AddExport(app, flags.exported)};
  app.footer(kFooter);  // after its commands, which else would repeat it
  return commands;
}

}  // namespace twin::cli
