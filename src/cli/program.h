#pragma once

#include "cli/command.h"

namespace twin::cli {

/// Reads the command line, runs the command, translates what it throws. Prints exactly one line
/// "panda-twin: error: ..." for anything that is an error. @returns the exit code.
[[nodiscard]] int RunProgram(int argc, const char* const* argv, Program& program);

}  // namespace twin::cli
