#pragma once

#include <string>
#include <utility>
#include <vector>

#include "twin/run/console.h"
#include "twin/run/result_folder.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Inputs of WriteSessionResults(). All must outlive the call.
struct SessionInputs {
  const run::ResultFolder& out;  ///< prepared and cleared; holds the complete log
  const scenario::Scenario& scenario;
  const scenario::RobotData& robot;
  const run::RunFiles& files;
  bool makes_video = true;                                 ///< of a log with scenes
  std::vector<std::pair<std::string, std::string>> facts;  ///< "drive": "lockstep"; for the page
  run::Console& console;
};

/// Writes what a served session leaves beside its log:
///
///     report.html, summary.json, scenario.yaml   a row for each motion, by client
///     video.mp4, contact_sheet.png               without the times at which nothing moves
///     motions/N/run.mcap                         of motion N: to half a second after it
///     motions/N/plots/*.svg, explain.html        as a run's; the latter for an abort
///
/// Report and summary come first, and the report again at the end with what was added to it, so
/// that an interrupted call leaves them complete.
///
/// Threads: one thread. Real-time: no.
/// @throws InputError, EnvironmentError as record::LogReader, report::WritePlots and
/// replay::Recording. What prevents the video alone is a warning. run::Interrupted when the console
/// is.
void WriteSessionResults(const SessionInputs& inputs);

}  // namespace twin::application
