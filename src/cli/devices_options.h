#pragma once

#include <CLI/CLI.hpp>

#include "cli/devices_command.h"

namespace twin::cli {

/// Adds the command `devices`. @param flags  filled by parsing; must outlive the app. @returns it.
CLI::App* AddDevices(CLI::App& app, DevicesFlags& flags);

}  // namespace twin::cli
