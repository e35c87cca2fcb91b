#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "twin/application/application.h"
#include "twin/application/record_run.h"
#include "twin/application/seed_run.h"

// An application's runs with many seeds, and their statistics.
namespace twin::application {

/// A finding over all runs that have it.
struct FindingSpread {
  std::string quantity;
  std::string unit{};
  std::string demand{};
  std::vector<double> values{};  ///< in order of seeds
  double median = 0;
  double largest = 0;
  std::uint64_t largest_seed = 0;
  int missed = 0;  ///< runs that missed the demand
};

struct MonteCarloResult {
  std::vector<SeedOutcome> outcomes;  ///< in order of seeds; fewer after an interruption
  int succeeded = 0;
  double least_share = 0;  ///< of success, 95 % confidence interval
  double most_share = 1;

  [[nodiscard]] double share() const noexcept {
    return outcomes.empty() ? 0 : succeeded / static_cast<double>(outcomes.size());
  }
  /// One entry per quantity, in the order of the first run that has it.
  [[nodiscard]] std::vector<FindingSpread> Spreads() const;
};

/// Runs an application once per seed, from the scenario's seed on, in lockstep and without logs.
/// The results do not depend on the number of threads. All runs share one compiled model in
/// files.cache.
///
/// @param on_outcome  receives each outcome when its run ends, one at a time, on any of the
/// threads; must not throw; may be empty. @param interrupted  set from a signal handler; may be
/// null.
/// @throws InputError if an option is out of range, the scenario is not in lockstep, or the first
/// run cannot start. Later runs that throw count as failed.
[[nodiscard]] MonteCarloResult RunSeeds(
    const scenario::Scenario& scenario, const run::Catalogue& catalogue, const run::RunFiles& files,
    const SeedsOptions& options, const std::function<void(const SeedOutcome&)>& on_outcome = {},
    const volatile bool* interrupted = nullptr);

}  // namespace twin::application
