#pragma once

#include <string>
#include <vector>

#include "cli/command.h"

namespace twin::cli {

/// Adds "--flag=value" to the words of a command; nothing for an empty value.
void AddFlag(const char* flag, const std::string& value, std::vector<std::string>& words);

/// Replaces this process by a command of the Python package,
/// panda_twin.MODULE.main(words), which says itself what it lacks. Python is
/// $PANDA_TWIN_PYTHON, else, of a program in build/NAME, that of the checkout's .venv, which
/// scripts/setup makes, else python3; the package is one it has, else that beside the program in a
/// build folder.
/// @throws EnvironmentError when there is no such Python.
[[noreturn]] void BecomePython(const std::string& module, const std::vector<std::string>& words,
                               const Host& host);

}  // namespace twin::cli
