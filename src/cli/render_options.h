#pragma once

#include <CLI/CLI.hpp>

#include "cli/render_command.h"

namespace twin::cli {

/// Adds the command `render`. @param flags  filled by parsing; must outlive the app. @returns it.
CLI::App* AddRender(CLI::App& app, RenderFlags& flags);

}  // namespace twin::cli
