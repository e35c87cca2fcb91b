#pragma once

#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "cli/devices_command.h"
#include "cli/render_command.h"
#include "cli/video_command.h"

namespace twin::cli {

/// The flags of all commands.
struct Flags {
  RunFlags run;
  ServeFlags serve;
  ProxyFlags proxy;
  RenderFlags render;
  VideoFlags video;
  ExperimentFlags experiment;
  ValidateFlags validate;
  CheckFlags check;
  ExportFlags exported;
  ExplainFlags explain;
  DecodeFlags decode;
  DevicesFlags devices;
};

/// The parsed command line's way to a command. Each pointer is the app's.
struct Commands {
  const CLI::App* run = nullptr;
  const CLI::App* serve = nullptr;
  const CLI::App* proxy = nullptr;
  const CLI::App* render = nullptr;
  const CLI::App* video = nullptr;
  const CLI::App* experiment = nullptr;
  const CLI::App* validate = nullptr;
  const CLI::App* check = nullptr;
  const CLI::App* explain = nullptr;
  const CLI::App* decode = nullptr;
  const CLI::App* devices = nullptr;
  const CLI::App* exported = nullptr;
};

/// Adds all commands with their options and help. @param flags  filled by parsing; must outlive the
/// app.
[[nodiscard]] Commands AddCommands(CLI::App& app, Flags& flags);

}  // namespace twin::cli
