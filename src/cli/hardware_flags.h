#pragma once

#include <optional>
#include <string>

#include "cli/command.h"
#include "cli/terminal.h"
#include "twin/application/record_run.h"
#include "twin/run/run_history.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

// Flags of a robot at the other end of a wire, which may be a real arm.
namespace twin::cli {

struct HardwareFlags {
  std::optional<std::string> robot;       ///< HOST[:PORT]
  std::optional<std::string> robot_time;  ///< auto, wall or states
  bool allow = false;                     ///< the robot need not be a twin
  bool yes = false;                       ///< no operator is asked before the motion
  bool check_only = false;
  std::optional<double> max_speed;              ///< share of the scenario's, in (0, 1]
  std::string no_rehearsal;                     ///< why none is demanded
  std::optional<std::string> rehearsed_within;  ///< "24h"
};

/// @param text  "24h", or a time with its unit as in scenarios. @throws InputError otherwise, and
/// unless it is above 0.
[[nodiscard]] Duration RehearsedWithin(const std::string& text);

/// The flags that say which robot, and whether it may move.
void AddRobot(CLI::App& app, HardwareFlags& flags);
/// Those of run beside them.
void AddRehearsal(CLI::App& app, HardwareFlags& flags);

/// @throws InputError for flags that do not go with the scenario's backend, and for a real arm that
/// may move without --yes where no operator can be asked.
void RequireHardwareFlags(const HardwareFlags& flags, const scenario::Scenario& scenario);

/// What these flags demand of a run. Without --max-speed a scenario's first run on a real arm is at
/// a fifth of its speed. @param scenario  at its own speed. @param command  that rehearses it.
/// @param history, terminal  must outlive what is returned.
[[nodiscard]] application::HardwareOptions HardwareOf(
    const HardwareFlags& flags, const scenario::Scenario& scenario, const run::RunFiles& files,
    const std::string& command, const run::RunHistory& history, Terminal& terminal);

/// q_d (rad) of a remote robot; nothing is asked of it but states. @throws RobotFault without any.
[[nodiscard]] JointVector CurrentPositionOf(const run::Session& session,
                                            const backend::RobotAddress& robot);

}  // namespace twin::cli
