#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

#include "cli/log.h"
#include "twin/rt/find_program.h"
#include "twin/run/catalogue.h"

namespace twin::cli {

/// What the program returns.
enum ExitCode : int {
  kOk = 0,
  kFailed = 1,       ///< the run aborted, or a check failed
  kUsage = 2,        ///< the command line is wrong
  kBadInput = 3,     ///< a file or a value is not acceptable
  kEnvironment = 4,  ///< the host lacks something
  kInterrupted = 130,
};

/// What the host tells the program. The environment is read in main, and nowhere else.
struct Host {
  std::filesystem::path executable;
  std::filesystem::path meshes;  ///< folder panda_description, unless --meshes; empty: sought
  std::filesystem::path cache;   ///< folder of compiled models
  std::filesystem::path state;   ///< folder of the user's records of runs; empty: none
  std::string path;              ///< the search path of programs
  std::string python;            ///< which has the Python package; empty: sought
};

using rt::FindProgram;
using rt::RequireProgram;

/// What a command works with, and what came of it.
struct Program {
  Host host;
  run::Catalogue catalogue;
  std::shared_ptr<LogFlags> log_flags;
  Log log;
  int code = kOk;  ///< what the command returned

  [[nodiscard]] bool is_quiet() const noexcept { return log_flags->quiet; }
};

/// Adds an option that takes a value.
/// @param form  name and type as help shows them: "--out DIR"; without dashes a positional.
/// @param value  must outlive the command.
template <typename T>
CLI::Option* Add(CLI::App& command, const std::string& form, T& value, const char* text) {
  const std::size_t space = form.find(' ');
  CLI::Option* option = command.add_option(form.substr(0, space), value, text);
  return space == std::string::npos ? option : option->type_name(form.substr(space + 1));
}

/// The text of a file of src/cli/texts: "completion.zsh"; empty when there is none.
[[nodiscard]] std::string_view TextOf(std::string_view name);

/// Adds what follows the options in a command's help: src/cli/texts/help/NAME.txt, if there.
void AddFooter(CLI::App& command);

/// Adds -v, -q and --log-format, which every command has.
void AddLog(CLI::App& command, LogFlags& flags);

/// A command, and the flags that its options fill; the program owns both.
template <typename Flags>
struct AddedCommand {
  CLI::App& app;
  Flags& flags;
};

/// Adds a command with the flags of the log, and its footer.
/// @param run  what it does once its options are read. It may throw twin::Error, Interrupted, or a
/// CLI::ParseError for options that do not go together.
/// @param program  must outlive the command.
template <typename Flags>
AddedCommand<Flags> AddCommand(CLI::App& parent, Program& program, const char* name,
                               const char* text, int (*run)(const Flags&, const Program&)) {
  CLI::App& command = *parent.add_subcommand(name, text);
  auto flags = std::make_shared<Flags>();
  command.final_callback([flags, run, &program] { program.code = run(*flags, program); });
  AddLog(command, *program.log_flags);
  AddFooter(command);
  return {command, *flags};
}

/// Reads the command line, runs the command, translates what it throws. Logs exactly one line
/// "panda-twin: error: ..." for anything that is an error. @returns the exit code.
[[nodiscard]] int RunProgram(int argc, const char* const* argv, Program& program);

}  // namespace twin::cli
