#include "application/monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>

#include "twin/core/error.h"
#include "twin/core/text.h"
#include "twin/record/cycle_record.h"
#include "twin/run/run_records.h"

namespace twin::application {
namespace {

/// One run, with a watch for contacts and without a log.
SeedOutcome RunSeed(scenario::Scenario scenario, std::uint64_t seed,
                    const run::Catalogue& catalogue, const run::RunFiles& files, const Clock& clock,
                    const volatile bool* interrupted) {
  scenario.seed = seed;
  run::RunRecords records;
  ApplicationRun run(scenario, catalogue, files, &records, clock);
  if (const auto* truth = run.connection().truth) records.WatchContacts(*truth);
  run::RunHooks hooks;
  hooks.interrupted = interrupted;
  const TaskResult& task_result = run.Execute(hooks);
  const Evaluation evaluation =
      run.Evaluate({.log = {}, .contacts = records.contacts() ? &*records.contacts() : nullptr});
  SeedOutcome outcome{.seed = seed,
                      .succeeded = Succeeded(task_result, evaluation),
                      .failure = FailureOf(task_result, evaluation),
                      .findings = evaluation.findings,
                      .states_hash = run.result().states_hash};
  for (const StepReport& step : task_result.task.steps) {
    outcome.repeated += step.succeeded ? 0 : 1;
    outcome.duration = step.ended.time_since_epoch();
  }
  if (!task_result.task.failure.empty() && !task_result.task.steps.empty()) {
    outcome.failed_step = task_result.task.steps.back().name;
    --outcome.repeated;
  }
  return outcome;
}

}  // namespace

const Finding* SeedOutcome::Find(const std::string& quantity) const {
  const auto found = std::ranges::find(findings, quantity, &Finding::quantity);
  return found == findings.end() ? nullptr : &*found;
}

std::pair<double, double> WilsonInterval(int hits, int trials) noexcept {
  constexpr double kZ = 1.959963984540054;  // of the normal distribution, 95 %
  const double n = trials;
  const double p = hits / n;
  const double centre = (p + kZ * kZ / (2 * n)) / (1 + kZ * kZ / n);
  const double half = kZ * std::sqrt(p * (1 - p) / n + kZ * kZ / (4 * n * n)) / (1 + kZ * kZ / n);
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

std::vector<FindingSpread> MonteCarloResult::Spreads() const {
  std::vector<FindingSpread> spreads;
  std::vector<std::vector<double>> values;
  for (const SeedOutcome& outcome : outcomes) {
    for (const Finding& finding : outcome.findings) {
      const auto found = std::ranges::find(spreads, finding.quantity, &FindingSpread::quantity);
      const auto i = static_cast<std::size_t>(found - spreads.begin());
      if (found == spreads.end()) {
        spreads.push_back({.quantity = finding.quantity,
                           .unit = finding.unit,
                           .demand = finding.demand,
                           .largest = finding.value,
                           .largest_seed = outcome.seed});
        values.emplace_back();
      }
      values[i].push_back(finding.value);
      spreads[i].missed += finding.met == false ? 1 : 0;
      if (finding.value <= spreads[i].largest) continue;
      spreads[i].largest = finding.value;
      spreads[i].largest_seed = outcome.seed;
    }
  }
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    auto middle = values[i].begin() + static_cast<std::ptrdiff_t>(values[i].size() / 2);
    std::ranges::nth_element(values[i], middle);
    spreads[i].median = *middle;
  }
  return spreads;
}

MonteCarloResult RunSeeds(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                          const run::RunFiles& files, const Clock& clock,
                          const MonteCarloOptions& options,
                          const std::function<void(const SeedOutcome&)>& on_outcome) {
  RequireInRange("seeds", options.seeds, 1, 100'000);
  RequireInRange("threads", options.threads, 1, 64);
  if (!scenario.is_lockstep()) {
    throw InputError("seeds: runs of many seeds take drive: lockstep");
  }
  const auto is_interrupted = [&] {
    return options.interrupted != nullptr && *options.interrupted;
  };
  const auto seed_of = [&](int k) { return options.first_seed + static_cast<std::uint64_t>(k); };
  const auto run = [&](int k) {
    return RunSeed(scenario, seed_of(k), catalogue, files, clock, options.interrupted);
  };
  std::mutex mutex;
  std::vector<std::optional<SeedOutcome>> outcomes(static_cast<std::size_t>(options.seeds));
  const auto keep = [&](int k, SeedOutcome outcome) {
    const std::scoped_lock lock(mutex);
    if (on_outcome) on_outcome(outcome);
    outcomes[static_cast<std::size_t>(k)] = std::move(outcome);
  };
  // The first run compiles the model for the cache, and throws what makes every run impossible.
  keep(0, run(0));
  std::atomic<int> next{1};
  const auto work = [&] {
    for (int k = next++; k < options.seeds && !is_interrupted(); k = next++) {
      SeedOutcome outcome;
      try {
        outcome = run(k);
      } catch (const Error& error) {
        outcome = {.seed = seed_of(k), .failure = error.what()};
      }
      if (!is_interrupted()) keep(k, std::move(outcome));  // else the run is not complete
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 0; i < std::min(options.threads, options.seeds); ++i) workers.emplace_back(work);
  workers.clear();
  MonteCarloResult result;
  for (std::optional<SeedOutcome>& outcome : outcomes) {
    if (!outcome) continue;
    result.succeeded += outcome->succeeded ? 1 : 0;
    result.outcomes.push_back(std::move(*outcome));
  }
  std::tie(result.least_share, result.most_share) =
      WilsonInterval(result.succeeded, static_cast<int>(result.outcomes.size()));
  return result;
}

}  // namespace twin::application
