#include "cli/program.h"

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/interrupt.h"
#include "cli/options.h"
#include "cli/say.h"
#include "twin/core/error.h"

namespace twin::cli {
namespace {

/// One line, whatever the text holds: of one that is endless, its begin and its end, which has the
/// cure.
void PrintError(std::string_view text) {
  constexpr std::size_t kMost = 2000;
  std::string line(text);
  if (line.size() > kMost) line.replace(kMost / 2, line.size() - kMost, " ... ");
  for (char& c : line) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  std::fflush(stdout);
  Say(stderr, fmt::format("panda-twin: error: {}\n", line));
}

/// Runs `command` and turns what it throws into an exit code.
template <typename Command>
int Guarded(Command command) {
  try {
    return command();
  } catch (const Interrupted&) {
    PrintError("interrupted");
    return kInterrupted;
  } catch (const InputError& error) {
    PrintError(error.what());
    return kBadInput;
  } catch (const EnvironmentError& error) {
    PrintError(error.what());
    return kEnvironment;
  } catch (const Error& error) {
    PrintError(error.what());
    return kFailed;
  } catch (const std::system_error& error) {
    PrintError(
        fmt::format("the operating system refused: {}; are there limits on threads or files "
                    "(ulimit -u, ulimit -n)?",
                    error.what()));
    return kEnvironment;
  } catch (const std::bad_alloc&) {
    PrintError("out of memory; close other programs or use a smaller scenario");
    return kEnvironment;
  } catch (const std::exception& error) {
    PrintError(fmt::format("internal error, please report it: {}", error.what()));
    return kFailed;
  }
}

}  // namespace

std::string VersionText() {
#if defined(__clang__)
  constexpr const char* kCompiler = "clang " __clang_version__;
#else
  constexpr const char* kCompiler = "g++ " __VERSION__;
#endif
  return fmt::format("panda-twin {}\nMuJoCo {}\n{}", TWIN_VERSION, TWIN_MUJOCO_VERSION, kCompiler);
}

int RunProgram(int argc, const char* const* argv, const Host& host,
               const run::Catalogue& catalogue) {
  CLI::App app("A digital twin of the Franka Emika Panda and its 1 kHz control stack.",
               "panda-twin");
  app.set_version_flag("--version", &VersionText, "Show the version and exit");
  app.require_subcommand(1);
  Flags flags;
  const Commands commands = AddCommands(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version
    const int code = app.exit(done);
    return Guarded([&] {
      FinishOutput();
      return code;
    });
  } catch (const CLI::ParseError& error) {
    PrintError(fmt::format("{}; see panda-twin --help", error.what()));
    return kUsage;
  }
  return Guarded([&]() -> int {
    if (commands.run->parsed()) return RunCommand(flags.run, host, catalogue);
    if (commands.serve->parsed()) return ServeCommand(flags.serve, host, catalogue);
    if (commands.proxy->parsed()) return ProxyCommand(flags.proxy);
    if (commands.render->parsed()) return RenderCommand(flags.render, host);
    if (commands.video->parsed()) return VideoCommand(flags.video, host, catalogue);
    if (commands.experiment->parsed()) return ExperimentCommand(flags.experiment, host, catalogue);
    if (commands.validate->parsed()) return ValidateCommand(flags.validate, host, catalogue);
    if (commands.check->parsed()) return CheckCommand(flags.check, host);
    if (commands.explain->parsed()) return ExplainCommand(flags.explain);
    if (commands.devices->parsed()) return DevicesCommand(flags.devices, *catalogue.devices);
    if (commands.decode->parsed()) return DecodeCommand(flags.decode);
    return ExportCommand(flags.exported);
  });
}

}  // namespace twin::cli
