#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/ros_flags.h"
#include "cli/shared_flags.h"
#include "twin/application/serve_options.h"
#include "twin/application/served_session.h"

// Flags of the command serve: what they mean, and what it prints of them at its start.
namespace twin::cli {

struct ServeFlags : application::ServeOptions {
  ServeFlags() { dash = "--"; }

  NetworkFlags network;
  std::optional<double> seconds;  ///< after which it ends; absent: when it is interrupted
  std::optional<std::filesystem::path> control;  ///< Unix socket of the control channel
  PageFlags page;
  RosFlags ros;
  DataFlags data;
};

/// @throws InputError for flags that do not go together.
void RequireServeAgreement(const ServeFlags& flags);

/// What the robot is, how its time passes, where and how programs made for it connect, and what
/// ends it: lines.
[[nodiscard]] std::string IntroductionOf(const ServeFlags& flags,
                                         application::ServedSession& session);

}  // namespace twin::cli
