#pragma once

#include <CLI/CLI.hpp>

#include "cli/video_command.h"

namespace twin::cli {

/// Adds the command `video` with its three task_result. @param flags  filled by parsing; must
/// outlive the app. @returns it.
CLI::App* AddVideo(CLI::App& app, VideoFlags& flags);

}  // namespace twin::cli
