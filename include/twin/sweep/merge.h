#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/run/catalogue.h"
#include "twin/sweep/points.h"
#include "twin/sweep/result.h"

namespace twin::sweep {

/// A run with its result.
struct Row {
  std::uint64_t run = 0;  ///< its number in the sweep
  Result result;
};

/// What the runs of a point say.
struct PointShare {
  std::uint64_t runs = 0;
  std::uint64_t failures = 0;
  double least = 0;  ///< of the share of failures, 95 % confidence interval (Wilson)
  double most = 1;

  [[nodiscard]] double share() const noexcept {
    return runs == 0 ? 0 : static_cast<double>(failures) / static_cast<double>(runs);
  }
};

/// Share of a group of runs that has not failed yet, over the robot's time. A run that succeeds
/// counts to the end: it is done and cannot fail any more, which is why this is no estimate for
/// runs that were broken off (Kaplan and Meier's), and ends at the share of successes.
struct SurvivalCurve {
  struct Step {
    double time_s = 0;
    double share = 1;  ///< from this time on, to the next step's
  };

  std::string label;  ///< the value of the first axis that the runs have in common, or "all runs"
  std::uint64_t runs = 0;
  std::uint64_t failures = 0;
  double end_s = 0;         ///< when the last run ends
  std::vector<Step> steps;  ///< in order of times; before the first the share is 1
};

/// Results in a sweep's folder that it has no use for.
struct LeftAside {
  std::uint64_t other_version = 0;  ///< of the program
  std::uint64_t not_needed = 0;     ///< of points that ended before
  std::uint64_t other = 0;          ///< of another sweep, or other models

  [[nodiscard]] std::uint64_t count() const noexcept { return other_version + not_needed + other; }
  /// "3 of another version of the program, 2 of points that ended before".
  [[nodiscard]] std::string Text() const;
};

/// All results of a sweep, but for their rows: a million of those is as much as a million of files.
struct Merged {
  std::uint64_t runs = 0;  ///< without those that a point did not need
  std::uint64_t failures = 0;
  std::vector<PointShare> points;  ///< in order
  std::vector<Row> worst;  ///< at most ten failures: those that ended farthest from the goal
  std::vector<SurvivalCurve> survival;  ///< at most eight
  LeftAside left_aside;
  std::string digest;  ///< of address, states_hash and outcome of all runs; 16 digits

  [[nodiscard]] double success_percent() const noexcept {
    return 100.0 * static_cast<double>(runs - failures) / static_cast<double>(runs);
  }
};

/// Reads all results, each once, and writes runs.csv, points.csv, summary.json, report.html and, of
/// the worst failures, worst/<address>.yaml: the scenario that repeats it. What an earlier merge
/// wrote is replaced, once all results have been read. Takes 40 bytes for each point and 16
/// for each run.
///
/// Threads: one thread. @throws twin::Error naming how many runs are missing and the first of them;
/// EnvironmentError naming a file that cannot be written; as Sweep::ScenarioOf.
[[nodiscard]] Merged Merge(const Sweep& sweep, const run::RunFiles& files,
                           const std::filesystem::path& out);

}  // namespace twin::sweep
