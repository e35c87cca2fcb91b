#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_code.h"
#include "twin/teleop/device_registry.h"

namespace twin::cli {

struct DevicesFlags {
  std::string device;                 ///< which to show; empty: only list them
  std::vector<std::string> settings;  ///< its parameters, KEY=VALUE
  double seconds = 10;                ///< how long it is shown
  std::optional<std::string> record;  ///< file its samples go into
};

/// Lists the input devices of this machine, or shows what one device tells.
/// @param devices  those a scenario can name.
/// @returns kFailed when no sample came; kInterrupted. @throws twin::Error.
[[nodiscard]] ExitCode DevicesCommand(const DevicesFlags& flags,
                                      const teleop::DeviceRegistry& devices);

}  // namespace twin::cli
