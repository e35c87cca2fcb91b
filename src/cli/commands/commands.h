#pragma once

#include "cli/command.h"

// Every command of the program: one file each, NAME.cc, with its options, its help and what it
// does.
namespace twin::cli {

void AddRun(CLI::App& app, Program& program);
void AddMoveTo(CLI::App& app, Program& program);
void AddServe(CLI::App& app, Program& program);
void AddRosCommand(CLI::App& app, Program& program);
void AddCtl(CLI::App& app, Program& program);
void AddProxy(CLI::App& app, Program& program);
void AddRender(CLI::App& app, Program& program);
void AddVideo(CLI::App& app, Program& program);
void AddExperiment(CLI::App& app, Program& program);
void AddSweep(CLI::App& app, Program& program);
void AddValidate(CLI::App& app, Program& program);
void AddSchema(CLI::App& app, Program& program);
void AddCheck(CLI::App& app, Program& program);
void AddExcite(CLI::App& app, Program& program);
void AddExplain(CLI::App& app, Program& program);
void AddCompare(CLI::App& app, Program& program);
void AddDecode(CLI::App& app, Program& program);
void AddDevices(CLI::App& app, Program& program);
void AddRobots(CLI::App& app, Program& program);
void AddExport(CLI::App& app, Program& program);
void AddCompletion(CLI::App& app, Program& program);

/// All of them, in the order of the help.
inline constexpr auto kCommands = {
    &AddRun,    &AddMoveTo,  &AddServe,      &AddRosCommand, &AddCtl,      &AddProxy,
    &AddRender, &AddVideo,   &AddExperiment, &AddSweep,      &AddValidate, &AddSchema,
    &AddCheck,  &AddExplain, &AddCompare,    &AddExcite,     &AddDecode,   &AddDevices,
    &AddRobots, &AddExport,  &AddCompletion};

}  // namespace twin::cli
