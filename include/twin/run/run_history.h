#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/run/catalogue.h"
#include "twin/run/remote.h"
#include "twin/scenario/scenario.h"

// What the user has run before: a rehearsal in the twin comes before a motion on a real arm.
namespace twin::run {

/// How a run ended.
struct PastRun {
  std::string hash;                    ///< RehearsalHash()
  std::string scenario;                ///< its name
  std::string robot;                   ///< "HOST:PORT" of a real arm; empty: a twin
  std::string failure;                 ///< empty: success
  double max_speed = 1;                ///< share of the scenario's speed, in (0, 1]
  std::optional<JointVector> q_start;  ///< where the arm began, rad; nullopt: not known
  Time ended{};                        ///< of a CalendarClock; RunHistory::Keep() sets it
};

/// Identifies what a rehearsal rehearses: every setting of the scenario except backend, drive,
/// pictures and log; the bytes of its controller.library and scene; the program's version. Two
/// scenarios with the same hash make the same motion on a robot.
[[nodiscard]] std::string RehearsalHash(const scenario::Scenario& scenario, const RunFiles& files);

/// The last run of each scenario, in the twin and on each robot: one small JSON file each in a
/// folder of the user, the thousand newest.
///
/// Threads: one; several programs may share a folder.
class RunHistory {
 public:
  /// @param folder    made when missing; empty: nothing is kept. @param calendar  must outlive it.
  RunHistory(std::filesystem::path folder, const Clock& calendar);

  /// Replaces the last run of the same hash and robot. @throws EnvironmentError naming the file
  /// that cannot be written.
  void Keep(PastRun run) const;

  /// @param robot  as PastRun::robot. @returns nullopt when there is none, or its file is damaged.
  [[nodiscard]] std::optional<PastRun> Find(std::string_view hash, std::string_view robot) const;

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
  [[nodiscard]] Time Now() const noexcept { return calendar_.Now(); }

 private:
  [[nodiscard]] std::filesystem::path FileOf(std::string_view hash, std::string_view robot) const;

  const std::filesystem::path folder_;
  const Clock& calendar_;
};

/// What a real arm demands before it moves.
struct RehearsalDemand {
  std::string hash;
  double max_speed = 1;  ///< of the run to come; rehearsed at least as fast
  Duration within = std::chrono::hours(24);
  std::string command;  ///< that makes a rehearsal
};

/// Whether the scenario was rehearsed in the twin: the last rehearsal of the same hash succeeded,
/// not slower, and not longer ago than demanded.
[[nodiscard]] CheckLine CheckRehearsal(const RunHistory& history, const RehearsalDemand& demand);

}  // namespace twin::run
