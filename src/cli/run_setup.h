#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/result_folder.h"
#include "cli/run_records.h"
#include "twin/backend/registry.h"
#include "twin/core/error.h"
#include "twin/fci/capture.h"
#include "twin/record/recorder.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

// What every run begins and ends with, be it one motion or an application.
namespace twin::cli {

/// The scenario with what the command line says in its place, validated.
/// @throws InputError as scenario::Load, and for flags that do not go together.
[[nodiscard]] scenario::Scenario LoadWithFlags(const RunFlags& flags, const Host& host);

[[nodiscard]] run::RealtimeSettings SettingsOf(const RunFlags& flags);

/// The folder of compiled models, made fit for use; empty, with a note, when it cannot be used.
[[nodiscard]] std::filesystem::path UsableCache(const Host& host);

/// @throws as scenario::FindDataDirectory.
[[nodiscard]] run::RunFiles FilesOf(const RunFlags& flags, const Host& host);

/// @throws EnvironmentError when a program that the results need is missing.
void RequirePrograms(const scenario::Scenario& scenario, bool wants_video, const Host& host);

/// Makes a run's connection to its robot. Before one on the network it says what of the scenario
/// has no effect there, begins what --capture keeps, and says whether the robot is reached.
/// @param capture  is made when the flags want one. @param connect  with the settings as they are
/// then; what it throws is thrown on.
void Connect(const scenario::Scenario& scenario, const RunFlags& flags, bool wants_video,
             run::RealtimeSettings& settings, std::optional<fci::Capture>& capture,
             const std::function<const backend::Connection&()>& connect);

/// Where a run's results are to be.
[[nodiscard]] std::filesystem::path OutOf(const scenario::Scenario& scenario,
                                          const RunFlags& flags);

/// Begins the log of a run, if the scenario wants one. Where nobody waits for the run, what is late
/// is lost: the log's records too. @throws as RunRecords::Log.
void BeginLog(RunRecords& records, const std::filesystem::path& path,
              const scenario::Scenario& scenario, const scenario::RobotData& robot,
              const run::RealtimeSettings& settings);

/// Carries out what makes a run and its results. Where that throws, no file is left that is not
/// whole but the log, if that could not be written (a full disk): what is there can be read. An
/// interrupt counts before whatever else it led to.
/// @throws Interrupted; else what `work` throws.
void CarryOut(RunRecords& records, const ResultFolder& out, const InterruptGuard& interrupt,
              const std::function<void()>& work);

/// What a log says of its run.
[[nodiscard]] record::RunInfo InfoOf(const scenario::Scenario& scenario,
                                     const scenario::RobotData& robot);

/// A note when the robot is simulated in primitive shapes.
void TellIfWithoutMeshes(const scenario::Scenario& scenario, const backend::Connection& connection);

/// Leaves the summary of a run that failed before its first motion, in place of an earlier run's
/// results. What fails here is told beside it.
void LeaveFailure(const scenario::Scenario& scenario, const RunFlags& flags,
                  const std::string& failure);

/// Makes a Session of these, and executes it. One that fails by its robot, or finds no plan, leaves
/// a summary, whenever that is; one that cannot be made of bad input, or on this host, leaves
/// nothing.
template <class Session>
ExitCode Carried(const scenario::Scenario& scenario, const RunFlags& flags, const Host& host,
                 const run::Catalogue& catalogue, std::optional<fci::Capture>& capture) {
  std::optional<Session> session;
  try {
    return session.emplace(scenario, flags, host, catalogue, capture).Execute();
  } catch (const InputError&) {
    throw;
  } catch (const EnvironmentError&) {
    throw;
  } catch (const Error& error) {
    const bool has_summary = session && session->has_summary();
    session.reset();  // it locks the folder
    if (!has_summary) LeaveFailure(scenario, flags, error.what());
    throw;
  }
}

/// After a run that went well: says which of its motions were further off their targets than the
/// scenario's max_deviation. Warns; @throws RobotFault when `strict`.
void EvaluateDeviations(const std::vector<run::FollowedMotion>& motions, bool strict);

/// What threads of either side had to say of their set-up.
void TellNotices(const std::vector<std::string>& workstation,
                 const std::vector<std::string>& robot);

/// What was captured of a run that failed is wanted most. What fails here is told beside it.
void KeepAfterFailure(std::optional<fci::Capture>& capture);

/// Largest resident size of the process, MB.
[[nodiscard]] double PeakMemoryMb();

}  // namespace twin::cli
