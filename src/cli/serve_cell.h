#pragma once

#include <filesystem>

#include "cli/command.h"
#include "cli/serve_flags.h"

namespace twin::cli {

/// Serves the robots of a scenario of several, each at a loopback address of its own: in the order
/// of their names from --bind on. Until it is interrupted or the flags' time is over. A cycle waits
/// for the answers of all robots in motion.
/// @param file  the scenario's. @throws InputError for flags of one robot; otherwise as
/// application::ServedSession. @returns the exit code.
int ServeCell(const std::filesystem::path& file, const ServeFlags& flags, const Program& program);

}  // namespace twin::cli
