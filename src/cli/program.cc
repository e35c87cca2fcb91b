#include "cli/command.h"

#include <unistd.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin::cli {
namespace {

constexpr const char* kProgramFooter = R"(Start here:
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

/// Runs `command` and turns what it throws into an exit code.
template <typename Command>
int Guarded(const Log& log, Command command) {
  const auto fail = [&log](int code, std::string_view text) {
    log->error(text);
    return code;
  };
  try {
    return command();
  } catch (const Interrupted&) {
    return fail(kInterrupted, "interrupted");
  } catch (const InputError& error) {
    return fail(kBadInput, error.what());
  } catch (const EnvironmentError& error) {
    return fail(kEnvironment, error.what());
  } catch (const Error& error) {
    return fail(kFailed, error.what());
  } catch (const std::system_error& error) {
    return fail(kEnvironment,
                fmt::format("the operating system refused: {}; are there limits on threads or "
                            "files (ulimit -u, ulimit -n)?",
                            error.what()));
  } catch (const std::bad_alloc&) {
    return fail(kEnvironment, "out of memory; close other programs or use a smaller scenario");
  } catch (const std::exception& error) {
    return fail(kFailed, fmt::format("internal error, please report it: {}", error.what()));
  }
}

/// What is wrong with a command line. CLI11 does not say which word is no command.
std::string DescribeError(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const std::vector<std::string> unread = command->remaining();
  const auto word =
      std::ranges::find_if(unread, [](const std::string& text) { return !text.starts_with('-'); });
  const auto commands = command->get_subcommands([](const CLI::App*) { return true; });
  if (commands.empty() || word == unread.end()) return error.what();
  std::vector<std::string_view> names;
  for (const CLI::App* one : commands) names.emplace_back(one->get_name());
  const auto nearest = Nearest(*word, names);
  return fmt::format("there is no command \"{}\"{}", *word,
                     nearest ? fmt::format("; did you mean \"{}\"?", *nearest) : "");
}

std::string VersionText() {
#if defined(__clang__)
  constexpr const char* kCompiler = "clang " __clang_version__;
#else
  constexpr const char* kCompiler = "g++ " __VERSION__;
#endif
  return fmt::format("panda-twin {}\nMuJoCo {}\n{}", TWIN_VERSION, TWIN_MUJOCO_VERSION, kCompiler);
}

}  // namespace

std::filesystem::path FindProgram(std::string_view name, std::string_view path) {
  while (!path.empty()) {
    const auto colon = path.find(':');
    std::filesystem::path file = std::filesystem::path(path.substr(0, colon)) / name;
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0) {
      return file;
    }
    path = colon == std::string_view::npos ? std::string_view() : path.substr(colon + 1);
  }
  return {};
}

void RequireProgram(std::string_view name, std::string_view path, std::string_view cure) {
  if (!FindProgram(name, path).empty()) return;
  throw EnvironmentError(fmt::format("the program {} is not installed; {}", name, cure));
}

void AddLog(CLI::App& command, LogFlags& flags) {
  command.add_flag("-v,--verbose", flags.verbose, "Log details too");
  command.add_flag("-q,--quiet", flags.quiet, "No progress and no summary; log and errors only");
  command.add_option("--log-format", flags.format, "Lines of the log: text or json")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->type_name("text|json")
      ->capture_default_str();
}

int RunProgram(int argc, const char* const* argv, Program& program) {
  CLI::App app("A digital twin of the Franka Emika Panda and its 1 kHz control stack.",
               "panda-twin");
  app.set_version_flag("--version", &VersionText, "Show the version and exit");
  app.require_subcommand(1);
  for (const auto add : kCommands) add(app, program);
  app.footer(kProgramFooter);  // after its commands, which else would repeat it
  return Guarded(program.log, [&] {
    try {
      app.parse(argc, argv);  // and runs the command
      return program.code;
    } catch (const CLI::Success& done) {  // --help, --version
      const int code = app.exit(done);
      FinishOutput();
      return code;
    } catch (const CLI::ParseError& error) {
      program.log->error("{}; see panda-twin --help", DescribeError(app, error));
      return static_cast<int>(kUsage);
    }
  });
}

}  // namespace twin::cli
