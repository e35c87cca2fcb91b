#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "cli/exit_code.h"
#include "twin/run/catalogue.h"

namespace twin::cli {

/// What the host tells the program. The environment is read in main, and nowhere else.
struct Host {
  std::filesystem::path executable;
  std::filesystem::path cache;  ///< folder of compiled models
  std::string path;             ///< the search path of programs
};

/// What a command works with, and what came of it.
struct Program {
  Host host;
  run::Catalogue catalogue;
  int code = kOk;  ///< what the command returned
};

/// Makes `run` what `command` does once its options are read.
/// `run` may throw a CLI::ParseError for options that do not do.
/// @param program  must outlive the command. @returns the flags that the options fill; the command
/// owns them.
template <typename Flags>
Flags& SetAction(CLI::App& command, Program& program, int (*run)(const Flags&, const Program&)) {
  auto flags = std::make_shared<Flags>();
  command.final_callback([flags, run, &program] { program.code = run(*flags, program); });
  return *flags;
}

}  // namespace twin::cli
