#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "cli/commands.h"
#include "twin/backend/registry.h"
#include "twin/run/remote.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

// What a run on a robot at the other end of a wire needs beyond any other: where it is, and the
// checks before it moves.
namespace twin::cli {

/// The backend of the command line, and with it the drive that it implies.
void ChooseBackend(std::string_view backend, scenario::Scenario& scenario);

/// @throws InputError when the flags of a remote robot and the scenario's drive do not go together.
void RequireRemoteFlags(const RunFlags& flags, const scenario::Scenario& scenario);

/// run::SlowDown with the robot's data. @param models  the models folder.
void SlowDown(scenario::Scenario& scenario, const std::filesystem::path& models, double share);

/// One note each for what of the scenario has no effect there. @param video  whether one is wanted.
void WarnIgnoredSettings(const scenario::Scenario& scenario, bool video);

/// Connects, and prints the first lines of the checks: whether the robot is reached, and whether a
/// real arm may move. @param connect  what it throws is thrown on. @throws InputError when the
/// robot does not say that it is a twin, and nothing allows hardware.
void TellReach(const run::RemoteSettings& robot, bool allow_hardware,
               const std::function<const backend::Connection&()>& connect);

/// Prints the other lines. @throws RobotFault when one of them is not well: nothing has moved.
/// @param check  the checks: Run::CheckStart, or an application's.
void RequireReady(const std::function<bool(const run::TellCheck&)>& check);

}  // namespace twin::cli
