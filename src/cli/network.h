#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

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
/// The same. @param bind_flag, allow_flag  what the flags are called, for messages.
[[nodiscard]] Listening ListeningOf(const std::string& bind,
                                    const std::optional<std::string>& allow,
                                    std::string_view bind_flag, std::string_view allow_flag);

/// Who may connect, for people.
[[nodiscard]] std::string DescribeAccess(const NetworkFlags& flags);

}  // namespace twin::cli
