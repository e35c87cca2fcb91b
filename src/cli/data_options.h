#pragma once

#include <CLI/CLI.hpp>

#include "cli/commands.h"

namespace twin::cli {

/// Adds --data and --meshes. @param flags  filled by parsing; must outlive the app.
void AddDataFlags(CLI::App& app, DataFlags& flags);

}  // namespace twin::cli
