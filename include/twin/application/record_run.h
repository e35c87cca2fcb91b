#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "twin/page/live_page.h"
#include "twin/run/catalogue.h"
#include "twin/run/console.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

// A run from its scenario to its folder of results.
namespace twin::application {

/// How a scenario is run, beside what it says itself.
struct RunOptions {
  std::filesystem::path scenario;  ///< its file, for messages
  std::filesystem::path out;       ///< folder of results
  std::string site;                ///< of the scenario, for people: "lab b"
  bool makes_video = true;         ///< where the scenario wants one; the log is the same without
  bool strict = false;             ///< an arm that was too far off its path is a failure
  bool allow_hardware = false;     ///< a robot at the other end of a wire need not be a twin
  std::optional<std::filesystem::path> capture{};  ///< backend fci: file of what goes over the wire
  std::optional<page::PageSettings> page{};        ///< where the operator's page is served
  run::RealtimeSettings settings{};
};

/// Runs a scenario's motion or application and writes what came of it. Where that fails by the
/// robot, or no plan is found, a summary is left, whenever it is; where the input is bad or the
/// host lacks something, nothing is left that is not whole but the log, if that could not be
/// written (a full disk): what is there can be read.
/// @throws RobotFault when the run aborted, failed or was off its path (strict), twin::Error
/// otherwise; run::Interrupted.
void RecordRun(const scenario::Scenario& scenario, const RunOptions& options,
               const run::RunFiles& files, const run::Catalogue& catalogue, run::Console& console);

/// Which seeds, and what is demanded of them.
struct SeedsOptions {
  int seeds = 100;             ///< from the scenario's on
  int threads = 2;             ///< so many at once
  double least_percent = 100;  ///< that must succeed
};

/// Carries an application out for many seeds, in lockstep, and writes a page, a table of all and a
/// summary. @param options  of these, out and site. @throws as RecordRun(); RobotFault when fewer
/// succeeded than wanted.
void RecordSeeds(const scenario::Scenario& scenario, const RunOptions& options,
                 const SeedsOptions& seeds, const run::RunFiles& files,
                 const run::Catalogue& catalogue, run::Console& console);

}  // namespace twin::application
