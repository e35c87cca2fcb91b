#include "cli/command.h"

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

/// "there is no flag --sead; did you mean --seed?".
std::string DescribeFlag(const CLI::App& command, const std::string& word) {
  const std::string flag = word.substr(0, word.find('='));
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::vector<std::string_view> names(known.begin(), known.end());
  const auto nearest = Nearest(flag, names);
  return fmt::format("there is no flag {}{}", flag,
                     nearest ? fmt::format("; did you mean {}?", *nearest) : "");
}

/// What is wrong with a command line. CLI11 says neither which word is no command, nor which flag
/// is none.
std::string DescribeError(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const std::vector<std::string> unread = command->remaining();
  const auto flag =
      std::ranges::find_if(unread, [](const std::string& text) { return text.starts_with("--"); });
  if (flag != unread.end() && *flag != "--") return DescribeFlag(*command, *flag);
  const auto word =
      std::ranges::find_if(unread, [](const std::string& text) { return !text.starts_with('-'); });
  const auto commands = command->get_subcommands([](const CLI::App*) { return true; });
  if (commands.empty() || word == unread.end()) return error.what();
  std::vector<std::string_view> names;
  names.reserve(commands.size());
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

void AddFooter(CLI::App& command) {
  const std::string_view text = TextOf(fmt::format("help/{}.txt", command.get_name()));
  command.footer(std::string(text.substr(0, text.find_last_not_of('\n') + 1)));
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
  AddFooter(app);  // after its commands, which else would repeat it
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
