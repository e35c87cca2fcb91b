#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/shared_flags.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/proxy/proxy.h"
#include "twin/run/remote.h"
#include "twin/scenario/link_section.h"

namespace twin::cli {
namespace {

struct ProxyFlags {
  std::string robot;  ///< HOST[:PORT]
  NetworkFlags network;
  std::filesystem::path link;                                    ///< file of faults; empty: none
  std::vector<std::pair<std::string_view, std::string>> faults;  ///< keys of a link, and values
  std::optional<std::uint64_t> seed;                             ///< absent: 1
  std::optional<int> cpu;                                        ///< of the threads that relay
  std::optional<double> seconds;                                 ///< as serve's
};

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
  proxy::ProxyConfig config;
  Listen(flags.network, config);
  const backend::RobotAddress robot = run::ParseRemote(flags.robot, "wall");
  const robot::LinkConfig link = LinkOf(flags);
  config.robot_arm = fci::Resolve(robot.host, robot.arm_port);
  config.robot_hand = config.robot_arm;
  ++config.robot_hand.port;
  config.state = link.state;
  config.command = link.command;
  config.seed = flags.seed.value_or(1);
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

int RunProxy(const ProxyFlags& flags, const Program& program) {
  RequireDuration(flags.seconds);
  const proxy::ProxyConfig config = ProxyConfigOf(flags);
  const MonotonicClock clock;
  const auto now = [&clock] { return clock.Now().time_since_epoch(); };
  const InterruptGuard interrupt;
  EventLog events(*program.log_flags);
  proxy::Proxy proxy(config, clock,
                     [&](std::string_view line) { events.Put(ToSeconds(now()), line); });
  events.Put(Introduction(proxy, config, flags.network));
  proxy.Run([&] {
    return interrupt.interrupted() || (flags.seconds && now() >= FromSeconds(*flags.seconds));
  });
  events.Put(TableOf(proxy.counts()));
  return interrupt.interrupted() ? kInterrupted : kOk;
}

/// Keys of a scenario's link that are flags, too (state_delay, --state-delay), and their help.
constexpr std::pair<std::string_view, const char*> kFaultFlags[] = {
    {"state_delay", "How long states take, such as \"200 us\""},
    {"state_loss", "Which states never arrive, such as \"0.1 %\""},
    {"state_duplication", "States that arrive a second time"},
    {"state_reordering", "States that are overtaken"},
    {"command_delay", "How long commands take"},
    {"command_loss", "Which commands never arrive"},
    {"command_duplication", "Commands that arrive a second time"},
    {"command_reordering", "Commands that are overtaken"}};

}  // namespace

void AddProxy(CLI::App& app, Program& program) {
  const auto [proxy, flags] = AddCommand(
      app, program, "proxy", "Pass a robot's wire on, with delays and losses by a seed", &RunProxy);
  Add(proxy, "--robot HOST[:PORT]", flags.robot, "The robot, or the twin that is served")
      ->required();
  AddNetwork(proxy, flags.network);
  Add(proxy, "--link FILE", flags.link,
      "All faults: a scenario, or a file with its section link only");
  for (const auto& [key, text] : kFaultFlags) {
    std::string flag = fmt::format("--{}", key);
    std::ranges::replace(flag, '_', '-');
    const auto keep = [&faults = flags.faults, key = key](const std::string& value) {
      faults.emplace_back(key, value);
    };
    proxy.add_option_function<std::string>(flag, keep, text)->type_name("YAML");
  }
  AddSeed(proxy, flags.seed, "Seed of the faults (default: 1)");
  Add(proxy, "--cpu N", flags.cpu, "Processor of the threads that relay datagrams");
  Add(proxy, "--for S", flags.seconds, "End after so long");
}

}  // namespace twin::cli
