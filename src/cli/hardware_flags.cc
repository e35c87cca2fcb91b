#include "cli/hardware_flags.h"

#include <utility>

#include <fmt/format.h>

#include "cli/shared_flags.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/run/remote.h"

namespace twin::cli {
namespace {

/// Share of its speed at which a scenario first runs on a real arm.
constexpr double kFirstSpeed = 0.2;

/// "HOST:PORT", as the history knows robots; empty in the twin.
std::string RobotOf(const HardwareFlags& flags) {
  if (!flags.allow) return {};
  const backend::RobotAddress at = run::ParseRemote(*flags.robot, "wall");
  return fmt::format("{}:{}", at.host, at.arm_port);
}

struct Speed {
  double share = 1;
  std::string text;
};

Speed SpeedOf(const HardwareFlags& flags, const scenario::Scenario& scenario,
              const std::string& hash, const run::RunHistory& history) {
  if (scenario.application) return {1, "the application's own: see its parameters"};
  if (flags.max_speed) {
    return {*flags.max_speed,
            fmt::format("{:.3g} of the scenario's (--max-speed)", *flags.max_speed)};
  }
  if (!flags.allow) return {1, "the scenario's own"};
  const auto last = history.Find(hash, RobotOf(flags));
  if (last && last->failure.empty()) return {1, "the scenario's own"};
  return {kFirstSpeed,
          fmt::format("{:.3g} of the scenario's, until it has run well on this robot once; to go "
                      "faster now, say --max-speed",
                      kFirstSpeed)};
}

}  // namespace

Duration RehearsedWithin(const std::string& text) {
  try {
    const bool in_hours = text.ends_with('h');
    const Duration within = in_hours
                                ? FromSeconds(3600 * ParseNumber(text.substr(0, text.size() - 1)))
                                : ParseDuration(text);
    if (within > Duration::zero()) return within;
  } catch (const InputError&) {
    // Told below, in the words of this flag.
  }
  throw InputError(fmt::format(
      "--rehearsed-within is \"{}\"; it must be a time above 0, such as 24h or 90min", text));
}

void AddRobot(CLI::App& app, HardwareFlags& flags) {
  Add(app, "--robot HOST[:PORT]", flags.robot, "fci: the robot, or the twin that is served");
  Add(app, "--robot-time auto|wall|states", flags.robot_time,
      "fci: the robot's time is the wall clock, or its states, as of a twin served in lockstep "
      "(default: auto, as the robot says)");
  app.add_flag("--allow-hardware", flags.allow,
               "fci: a real arm may move; needed wherever no twin says that it is one");
  app.add_flag("-y,--yes", flags.yes,
               "With --allow-hardware: do not ask for Enter before the arm moves");
}

void AddRehearsal(CLI::App& app, HardwareFlags& flags) {
  app.add_flag("--check-only", flags.check_only,
               "fci: print the checks before the first motion, all of them, and end");
  Add(app, "--max-speed F", flags.max_speed,
      "Share of the scenario's speed, in [0.001, 1]: all times are divided by it; 0.2 in a "
      "scenario's "
      "first run with --allow-hardware");
  Add(app, "--rehearsed-within TIME", flags.rehearsed_within,
      "With --allow-hardware: how long ago the scenario may have run in the twin (default: 24h)");
  Add(app, "--no-rehearsal REASON", flags.no_rehearsal,
      "With --allow-hardware: it need not have run in the twin, for this reason");
}

void RequireHardwareFlags(const HardwareFlags& flags, const scenario::Scenario& scenario) {
  const bool is_remote = scenario.is_remote();
  RefuseIf(!is_remote && (flags.robot || flags.robot_time || flags.allow || flags.check_only),
           "--robot, --robot-time, --allow-hardware and --check-only go with --backend fci");
  RefuseIf(is_remote && !flags.robot,
           "backend fci needs --robot HOST[:PORT]: a robot's address, or that of panda-twin serve");
  RefuseIf(!flags.allow && (flags.yes || flags.rehearsed_within || !flags.no_rehearsal.empty()),
           "--yes, --rehearsed-within and --no-rehearsal go with --allow-hardware");
  if (flags.rehearsed_within) static_cast<void>(RehearsedWithin(*flags.rehearsed_within));
  RefuseIf(flags.allow && !flags.yes && !flags.check_only && !Terminal::CanAsk(),
           "--allow-hardware asks for Enter before the arm moves, and the standard input is no "
           "terminal; say --yes if a person watches the arm");
}

application::HardwareOptions HardwareOf(const HardwareFlags& flags,
                                        const scenario::Scenario& scenario,
                                        const run::RunFiles& files, const std::string& command,
                                        const run::RunHistory& history, Terminal& terminal) {
  application::HardwareOptions options{.allowed = flags.allow,
                                       .check_only = flags.check_only,
                                       .rehearsal = {},
                                       .no_rehearsal = flags.no_rehearsal,
                                       .speed = {},
                                       .confirm = {},
                                       .history = &history};
  options.rehearsal.hash = run::RehearsalHash(scenario, files);
  options.rehearsal.command = command;
  if (flags.rehearsed_within) options.rehearsal.within = RehearsedWithin(*flags.rehearsed_within);
  Speed speed = SpeedOf(flags, scenario, options.rehearsal.hash, history);
  options.rehearsal.max_speed = speed.share;
  options.speed = std::move(speed.text);
  if (flags.allow && !flags.yes && !flags.check_only) {
    options.confirm = [&terminal](std::string_view what) { terminal.ConfirmMotion(what); };
  }
  return options;
}

JointVector CurrentPositionOf(const run::Session& session, const backend::RobotAddress& robot) {
  if (const auto q = session.ReadCurrentPosition()) return *q;
  throw RobotFault(fmt::format("{}:{} sends no state; does a firewall stop UDP to this machine?",
                               robot.host, robot.arm_port));
}

}  // namespace twin::cli
