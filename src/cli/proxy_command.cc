#include <cstdio>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/network.h"
#include "cli/say.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/proxy/proxy.h"
#include "twin/scenario/link.h"
#include "twin/scenario/remote.h"

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
  const scenario::RemoteSettings robot = scenario::ParseRemote(flags.robot, "wall");
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

void TellCounts(std::string_view what, const proxy::DirectionCounts& counts) {
  Say(stdout, fmt::format("{:<13}{:>9}{:>9}{:>9}{:>9}{:>11}{:>10}{:>9}{:>9}\n", what, counts.came,
                          counts.relayed, counts.delayed, counts.lost, counts.duplicated,
                          counts.reordered, counts.dropped, counts.foreign));
}

void TellAll(const proxy::ProxyCounts& counts) {
  Say(stdout,
      fmt::format("{:<13}{:>9}{:>9}{:>9}{:>9}{:>11}{:>10}{:>9}{:>9}\n", "datagrams", "came",
                  "relayed", "delayed", "lost", "duplicated", "reordered", "dropped", "foreign"));
  TellCounts("arm states", counts.arm.state);
  TellCounts("arm commands", counts.arm.command);
  TellCounts("hand states", counts.hand.state);
}

void Introduce(const proxy::Proxy& proxy, const proxy::ProxyConfig& config,
               const NetworkFlags& network) {
  Say(stdout, fmt::format("panda-twin proxy to the robot at {}, seed {}\n  arm   {}\n  hand  {}\n"
                          "  {}\n",
                          fci::ToString(config.robot_arm), config.seed, fci::ToString(proxy.arm()),
                          fci::ToString(proxy.hand()), DescribeAccess(network)));
  static_cast<void>(std::fflush(stdout));
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
  proxy::Proxy proxy(config, clock, [&now](std::string_view line) {
    Say(stdout, fmt::format("{:10.3f} s  {}\n", ToSeconds(now()), line));
    static_cast<void>(std::fflush(stdout));
  });
  Introduce(proxy, config, flags.network);
  proxy.Run([&] {
    return interrupt.interrupted() || (flags.seconds && now() >= FromSeconds(*flags.seconds));
  });
  TellAll(proxy.counts());
  return interrupt.interrupted() ? kInterrupted : kOk;
}

}  // namespace twin::cli
