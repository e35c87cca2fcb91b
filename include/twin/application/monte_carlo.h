#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "twin/application/application.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Which runs, and how many at once.
struct MonteCarloOptions {
  std::uint64_t first_seed = 1;
  int seeds = 100;  ///< in [1, 100000]; one after the other from the first
  int threads = 2;  ///< in [1, 64]; what comes out does not depend on it
  const volatile bool* interrupted = nullptr;  ///< set from a signal handler; may be null
};

/// What became of one seed.
struct SeedOutcome {
  std::uint64_t seed = 0;
  bool succeeded = false;
  std::string failure{};      ///< as FailureOf(); of a run that threw what it said
  std::string failed_step{};  ///< empty: the task was done, and a demand was missed
  int repeated = 0;           ///< attempts that failed and were made again
  std::vector<Finding> findings{};
  Duration duration{};  ///< of the run, on the robot's clock
  std::uint64_t states_hash = 0;
};

/// A finding over all runs that have it.
struct FindingSpread {
  std::string quantity;
  std::string unit{};
  std::string demand{};
  double median = 0;
  double largest = 0;
  std::uint64_t largest_seed = 0;
  int missed = 0;  ///< in how many its demand was missed
};

struct MonteCarloResult {
  std::vector<SeedOutcome> outcomes;  ///< in order of their seeds; fewer when it was interrupted
  int succeeded = 0;
  double least_share = 0;  ///< of success, by Wilson's interval of 95 %
  double most_share = 1;

  [[nodiscard]] double share() const noexcept {
    return outcomes.empty() ? 0 : succeeded / static_cast<double>(outcomes.size());
  }
  /// Of findings by their words, in the order of the first run that has them. What is told in other
  /// words where something is wrong counts under its own.
  [[nodiscard]] std::vector<FindingSpread> Spreads() const;
};

/// The interval in which a share lies, of which `hits` of `trials` were seen, with a probability of
/// 95 % (Wilson's score; Wilson 1927). @pre 0 <= hits <= trials, trials > 0.
[[nodiscard]] std::pair<double, double> WilsonInterval(int hits, int trials) noexcept;

/// Carries an application out once for every seed, in lockstep and without logs: what a method
/// bears, in figures. The scenario's own seed does not count. Objects that only differ in what is
/// drawn share one compiled model in files.cache.
///
/// Threads: one thread; `told` is called on it, in order of the runs' ends.
/// @param clock  as ApplicationRun's. @param told  each outcome as it comes; may be empty.
/// @throws InputError when an option is out of range, the scenario is not in lockstep, or the first
/// run cannot be made; a run that throws later has failed with what it said.
[[nodiscard]] MonteCarloResult RunSeeds(const scenario::Scenario& scenario,
                                        const run::Catalogue& catalogue, const run::RunFiles& files,
                                        const Clock& clock, const MonteCarloOptions& options,
                                        const std::function<void(const SeedOutcome&)>& told = {});

}  // namespace twin::application
