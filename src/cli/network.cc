#include "cli/network.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::cli {

Listening ListeningOf(const NetworkFlags& flags) {
  Listening listening;
  listening.address = fci::Resolve(flags.bind, 0).address;
  if (flags.allow) listening.allow = fci::ParseNetwork(*flags.allow);
  if (fci::IsLoopback(listening.address) || listening.allow) return listening;
  throw InputError(fmt::format(
      "--bind {} lets other machines move the robot: name the network that may, with --allow "
      "ADDRESS/BITS, or leave --bind out",
      flags.bind));
}

std::string DescribeAccess(const NetworkFlags& flags) {
  if (!flags.allow) return "open to this machine only";
  return fmt::format(
      "open to this machine and to {}: who is there can move the robot, without a password",
      *flags.allow);
}

}  // namespace twin::cli
