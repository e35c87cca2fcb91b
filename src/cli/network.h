#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "twin/fci/sockets.h"

// Where a command listens, and who may connect: by default nobody from elsewhere, since whoever
// connects can move the robot.
namespace twin::cli {

struct Listening {
  std::uint32_t address = 0;
  std::optional<fci::Network> allow;
};

/// @throws InputError when an address is none, or others could connect without being named.
[[nodiscard]] Listening ListeningOf(const NetworkFlags& flags);

/// Who may connect, for people.
[[nodiscard]] std::string DescribeAccess(const NetworkFlags& flags);

}  // namespace twin::cli
