#pragma once

#include <filesystem>
#include <string>

#include "twin/application/record_run.h"
#include "twin/scenario/cell.h"

// Runs of a scenario of several robots, from its file to its folder of results.
namespace twin::application {

/// A run's inputs. All must outlive the run.
struct CellInputs {
  const scenario::Cell& cell;
  const RunOptions& options;  ///< of no hardware, page or capture
  const run::RunFiles& files;
  const run::Catalogue& catalogue;
  run::Console& console;
};

/// Runs the motions and applications of all robots of a cell, from one instant on, and writes their
/// results: those of each robot, as of a run of its own, into a folder of its name, and summary,
/// scenario and video of all beside them. Robots of one island (run::Islands) share a model and
/// take each step together; INT holds an arm whose motion has ended until the last has. Their
/// applications may tell each other what they do (Partners).
///
/// In real time all robots share one thread (loop::SharedTime), and each has workstation threads of
/// its own. They get ready one after the other.
///
/// Where a robot's motion fails, the others go on: as in a lab, nothing stops them.
/// @throws RobotFault naming the robots that aborted or failed; otherwise as RecordRun().
void RecordCell(const CellInputs& inputs);

/// What validate says of a cell. @throws InputError, and others, as Validate() and RecordCell().
[[nodiscard]] std::string ValidateCell(const scenario::Cell& cell,
                                       const std::filesystem::path& file,
                                       const run::Catalogue& catalogue, const run::RunFiles& files);

}  // namespace twin::application
