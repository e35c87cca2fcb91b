#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "twin/application/partners.h"
#include "twin/page/live_page.h"
#include "twin/run/catalogue.h"
#include "twin/run/console.h"
#include "twin/run/run.h"
#include "twin/run/run_history.h"
#include "twin/scenario/scenario.h"

// Runs of a scenario, from its file to its folder of results.
namespace twin::application {

/// What precedes and follows a motion for the sake of a real arm.
struct HardwareOptions {
  bool allowed = false;     ///< a remote robot need not be a twin; the demands below then hold
  bool check_only = false;  ///< a remote robot is checked, and not moved
  run::RehearsalDemand rehearsal{};  ///< its hash and speed are also those that are recorded
  std::string no_rehearsal;          ///< why none is demanded; empty: one is
  std::string speed{};               ///< in words, for the checks: "0.2 of the scenario's: ..."
  std::string to_start{};            ///< command that brings the arm to the start; may be empty
  /// Asks whether to move, and waits for the answer; empty: no operator is asked.
  /// @throws run::Interrupted when the answer is no.
  std::function<void(std::string_view what)> confirm{};
  /// Keeps how runs end; null: they are not kept, and no hardware is allowed. Must outlive the run.
  const run::RunHistory* history = nullptr;
};

/// Options of a run, in addition to the scenario's settings.
struct RunOptions {
  std::filesystem::path scenario;  ///< its file, for messages
  std::filesystem::path out;       ///< folder of results
  std::string site;                ///< of the scenario, for the report: "lab b"
  bool makes_video = true;  ///< when the scenario asks for one; the log does not depend on it
  bool makes_plots = true;  ///< from the log, and an application's report, which has them
  bool has_fine_pictures = false;  ///< run::Fine()
  bool strict = false;             ///< a deviation above max_deviation is a failure
  HardwareOptions hardware{};
  std::optional<std::filesystem::path> capture{};  ///< backend fci: file of the wire's packets
  std::optional<page::PageSettings> page{};        ///< address of the operator's page
  bool waits_for_visitor = false;                  ///< begins when the page is first opened
  run::RealtimeConfig settings{};
};

/// Programs of the host that make a run's results.
struct NeededPrograms {
  bool ffmpeg = false;
  bool gnuplot = false;
};
[[nodiscard]] NeededPrograms ProgramsFor(const scenario::Scenario& scenario,
                                         const RunOptions& options);

/// A run's inputs. All must outlive the run.
struct RunInputs {
  const scenario::Scenario& scenario;
  const RunOptions& options;
  const run::RunFiles& files;
  const run::Catalogue& catalogue;
  run::Console& console;
  const Partners* partners = nullptr;  ///< other robots of its cell; null: the robot is alone
};

/// Runs a scenario's motion or application and writes its results. With check_only it prints the
/// checks that precede the first motion, all of them, and writes nothing. A failure by the robot,
/// or a goal without a plan, leaves a summary. Invalid input or a missing resource of the host
/// leaves nothing partial but the log, if it could not be written to its end (a full disk).
/// @throws RobotFault when the run aborted, failed or left its path (strict), or a check failed;
/// InputError when a real arm may move without being allowed or rehearsed; twin::Error
/// otherwise; run::Interrupted.
void RecordRun(const RunInputs& inputs);

/// Which seeds, and the demand on them.
struct SeedsOptions {
  int seeds = 100;             ///< from the scenario's on, in [1, 100000]
  int threads = 2;             ///< in [1, 64]
  double least_percent = 100;  ///< of the seeds that must succeed
};

/// Carries an application out for many seeds, in lockstep, and writes a report, a table of all
/// seeds and a summary. @param inputs  of the options only out and site count.
/// @throws as RecordRun(); RobotFault when fewer seeds succeed than demanded.
void RecordSeeds(const RunInputs& inputs, const SeedsOptions& options);

/// A check before a robot's first motion as people read it, with the line's end.
[[nodiscard]] std::string LineOf(const run::CheckLine& line);

/// @param is_allowed  it says that it is a twin, or a real arm may move. @throws InputError saying
/// what a real arm takes.
void RequireAllowed(bool is_allowed, const backend::RobotAddress& robot);

}  // namespace twin::application
