#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/messages.h"
#include "cli/network.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/proxy/proxy.h"
#include "twin/scenario/link.h"
#include "twin/run/remote.h"

namespace twin::cli {
namespace {

robot::LinkConfig LinkOf(const ProxyFlags& flags) {
  if (!flags.link.empty() && !flags.faults.empty()) {
    throw InputError(
        "--link and flags of single faults do not go together; put all of them into the file, or "
        "leave it out");
  }
  if (!flags.link.empty()) return scenario::MakeLink(scenario::LoadLink(flags.link));
  if (flags.faults.empty()) return {};
  std::string text;
  for (const auto& [key, value] : flags.faults) text += fmt::format("{}: {}\n", key, value);
  return scenario::MakeLink(scenario::ParseLink(text, "flags"));
}

proxy::ProxyConfig ProxyConfigOf(const ProxyFlags& flags) {
  const Listening listening = ListeningOf(flags.network);
  const run::RemoteSettings robot = run::ParseRemote(flags.robot, "wall");
  const robot::LinkConfig link = LinkOf(flags);
  proxy::ProxyConfig config;
  config.address = listening.address;
  config.allow = listening.allow;
  config.arm_port = flags.network.arm_port;
  config.hand_port = flags.network.hand_port;
  config.robot_arm = fci::Resolve(robot.host, robot.arm_port == 0 ? fci::kArmPort : robot.arm_port);
  config.robot_hand = config.robot_arm;
  ++config.robot_hand.port;
  config.state = link.state;
  config.command = link.command;
  config.seed = flags.seed;
  config.cpu = flags.cpu;
  return config;
}

std::string LineOf(std::string_view what, const proxy::DirectionCounts& counts) {
  return fmt::format("{:<13}{:>9}{:>9}{:>9}{:>9}{:>11}{:>10}{:>9}{:>9}\n", what, counts.came,
                     counts.relayed, counts.delayed, counts.lost, counts.duplicated,
                     counts.reordered, counts.dropped, counts.foreign);
}

std::string TableOf(const proxy::ProxyCounts& counts) {
  return fmt::format("{:<13}{:>9}{:>9}{:>9}{:>9}{:>11}{:>10}{:>9}{:>9}\n", "datagrams", "came",
                     "relayed", "delayed", "lost", "duplicated", "reordered", "dropped",
                     "foreign") +
         LineOf("arm states", counts.arm.state) + LineOf("arm commands", counts.arm.command) +
         LineOf("hand states", counts.hand.state);
}

std::string Introduction(const proxy::Proxy& proxy, const proxy::ProxyConfig& config,
                         const NetworkFlags& network) {
  return fmt::format("panda-twin proxy to the robot at {}, seed {}\n  arm   {}\n  hand  {}\n  {}\n",
                     fci::ToString(config.robot_arm), config.seed, fci::ToString(proxy.arm()),
                     fci::ToString(proxy.hand()), DescribeAccess(network));
}

}  // namespace

ExitCode ProxyCommand(const ProxyFlags& flags) {
  if (flags.seconds && !(*flags.seconds > 0)) {
    throw InputError(fmt::format("--for is {} s; it must be above 0", *flags.seconds));
  }
  const proxy::ProxyConfig config = ProxyConfigOf(flags);
  const MonotonicClock clock;
  const auto now = [&clock] { return clock.Now().time_since_epoch(); };
  const InterruptGuard interrupt;
  Messages messages;
  proxy::Proxy proxy(config, clock, [&](std::string_view line) {
    messages.Put(fmt::format("{:10.3f} s  {}\n", ToSeconds(now()), line));
  });
  messages.Put(Introduction(proxy, config, flags.network));
  proxy.Run([&] {
    return interrupt.interrupted() || (flags.seconds && now() >= FromSeconds(*flags.seconds));
  });
  messages.Put(TableOf(proxy.counts()));
  return interrupt.interrupted() ? kInterrupted : kOk;
}

}  // namespace twin::cli
