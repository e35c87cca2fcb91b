#include "cli/network.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::cli {

Listening ListeningOf(const NetworkFlags& flags) {
  return ListeningOf(flags.bind, flags.allow, "--bind", "--allow");
}

Listening ListeningOf(const std::string& bind, const std::optional<std::string>& allow,
                      std::string_view bind_flag, std::string_view allow_flag) {
  Listening listening;
  listening.address = fci::Resolve(bind, 0).address;
  if (allow) listening.allow = fci::ParseNetwork(*allow);
  if (fci::IsLoopback(listening.address) || listening.allow) return listening;
  throw InputError(
      fmt::format("{0} {1} lets other machines move the robot: name the network that may, with {2} "
                  "ADDRESS/BITS, or leave {0} out",
                  bind_flag, bind, allow_flag));
}

std::string DescribeAccess(const NetworkFlags& flags) {
  if (!flags.allow) return "open to this machine only";
  return fmt::format(
      "open to this machine and to {}: who is there can move the robot, without a password",
      *flags.allow);
}

}  // namespace twin::cli
