#pragma once

#include "cli/commands.h"

namespace twin::cli {

/// Reads the command line, runs the command, translates what it throws. Prints exactly one line
/// "panda-twin: error: ..." for anything that is an error.
[[nodiscard]] int RunProgram(int argc, const char* const* argv, const Host& host,
                             const run::Catalogue& catalogue);

}  // namespace twin::cli
