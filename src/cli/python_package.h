#pragma once

#include <map>
#include <string>
#include <vector>

#include "cli/command.h"

namespace twin::cli {

/// Adds "--flag=value" to the words of a command; nothing for an empty value.
void AddFlag(const char* flag, const std::string& value, std::vector<std::string>& words);

/// Options whose values the Python package reads, and checks: they are handed over as they are.
class HandedOver {
 public:
  /// @param form  as of cli::Add().
  CLI::Option* Add(CLI::App& command, const std::string& form, const char* text);
  /// Positionals and the options that were given, with --quiet where the program is.
  [[nodiscard]] std::vector<std::string> Words(const Program& program) const;

  std::vector<std::string> positionals;

 private:
  std::map<std::string, std::string> values_;  ///< by flag; a value stays where it is in memory
};

/// Replaces this process by a command of the Python package,
/// panda_twin.MODULE.main(words), which says itself what it lacks. Python is
/// $PANDA_TWIN_PYTHON, else, of a program in build/NAME, that of the checkout's .venv, which
/// scripts/setup makes, else python3; the package is one it has, else that beside the program in a
/// build folder.
/// @throws EnvironmentError when there is no such Python.
[[noreturn]] void BecomePython(const std::string& module, const std::vector<std::string>& words,
                               const Host& host);

}  // namespace twin::cli
