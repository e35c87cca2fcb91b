#include "twin/application/monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "twin/application/application_run.h"
#include "twin/application/evidence.h"
#include "twin/application/page.h"
#include "twin/core/error.h"
#include "twin/core/require.h"
#include "twin/rt/cycle_record.h"

namespace twin::application {
namespace {

/// Looks at what touches, and keeps nothing else.
class Watch final : public rt::RecordSink {
 public:
  void Begin(const plant::TruthProbe& truth) { contacts_.emplace(truth); }
  void Put(const rt::CycleRecord& record) noexcept override {
    if (contacts_) contacts_->Look(record.at);
  }
  void Put(const rt::TickRecord& /*record*/) noexcept override {}
  [[nodiscard]] const plant::ContactWatch* contacts() const noexcept {
    return contacts_ ? &*contacts_ : nullptr;
  }

 private:
  std::optional<plant::ContactWatch> contacts_;
};

/// The runs of one call, and the threads that share them.
class Runs {
 public:
  Runs(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
       const run::RunFiles& files, const Clock& clock, const MonteCarloOptions& options)
      : scenario_(scenario),
        catalogue_(catalogue),
        files_(files),
        clock_(clock),
        options_(options),
        outcomes_(static_cast<std::size_t>(options.seeds)) {}

  /// The first makes the compiled model that the others take from the cache, and tells by its
  /// exception what is wrong with all.
  void First() { Keep(0, Carry(0)); }

  void Work() {
    for (int k = next_.fetch_add(1); k < options_.seeds && !interrupted(); k = next_.fetch_add(1)) {
      SeedOutcome outcome;
      try {
        outcome = Carry(k);
      } catch (const Error& error) {
        outcome = {.seed = SeedOf(k), .failure = error.what()};
      }
      if (!interrupted()) Keep(k, std::move(outcome));  // it was cut short
    }
    const std::scoped_lock lock(mutex_);
    ++idle_;
    changed_.notify_one();
  }

  /// Tells outcomes as they come, until so many threads have nothing left to do.
  void Tell(int threads, const std::function<void(const SeedOutcome&)>& told) {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return told_ < ended_.size() || idle_ == threads; });
      if (told_ == ended_.size()) return;
      const SeedOutcome outcome = *outcomes_[static_cast<std::size_t>(ended_[told_++])];
      lock.unlock();
      if (told) told(outcome);
      lock.lock();
    }
  }

  [[nodiscard]] MonteCarloResult Result() const {
    MonteCarloResult result;
    for (const auto& outcome : outcomes_) {
      if (!outcome) continue;
      result.outcomes.push_back(*outcome);
      result.succeeded += outcome->succeeded ? 1 : 0;
    }
    if (result.outcomes.empty()) return result;
    const auto trials = static_cast<int>(result.outcomes.size());
    std::tie(result.least_share, result.most_share) = WilsonInterval(result.succeeded, trials);
    return result;
  }

 private:
  [[nodiscard]] std::uint64_t SeedOf(int k) const noexcept {
    return options_.first_seed + static_cast<std::uint64_t>(k);
  }
  [[nodiscard]] bool interrupted() const noexcept {
    return options_.interrupted != nullptr && *options_.interrupted;
  }

  [[nodiscard]] SeedOutcome Carry(int k) const {
    scenario::Scenario scenario = scenario_;
    scenario.seed = SeedOf(k);
    Watch watch;
    ApplicationRun run(scenario, catalogue_, files_, &watch, clock_);
    const plant::TruthProbe* truth = run.connection().truth;
    if (truth != nullptr) watch.Begin(*truth);
    run::RunHooks hooks;
    hooks.interrupted = options_.interrupted;
    const TaskResult& task_result = run.Execute(hooks);
    const Evaluation evaluation =
        run.Evaluate({.log = {}, .truth = truth, .contacts = watch.contacts()});
    SeedOutcome outcome{.seed = scenario.seed,
                        .succeeded = Succeeded(task_result, evaluation),
                        .failure = FailureOf(task_result, evaluation)};
    for (const StepReport& step : task_result.task.steps) {
      outcome.repeated += step.succeeded ? 0 : 1;
      outcome.duration = step.ended.time_since_epoch();
    }
    if (!task_result.task.failure.empty() && !task_result.task.steps.empty()) {
      outcome.failed_step = task_result.task.steps.back().name;
      --outcome.repeated;
    }
    outcome.findings = evaluation.findings;
    outcome.states_hash = run.result().states_hash;
    return outcome;
  }

  void Keep(int k, SeedOutcome outcome) {
    const std::scoped_lock lock(mutex_);
    outcomes_[static_cast<std::size_t>(k)] = std::move(outcome);
    ended_.push_back(k);
    changed_.notify_one();
  }

  const scenario::Scenario& scenario_;
  const run::Catalogue& catalogue_;
  const run::RunFiles& files_;
  const Clock& clock_;
  const MonteCarloOptions options_;
  std::atomic<int> next_{1};  // only handed out: relaxed would do, seq_cst is what reads plainest
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<SeedOutcome>> outcomes_;  ///< under the mutex, as all below
  std::vector<int> ended_;                            ///< in order of their ends
  std::size_t told_ = 0;
  int idle_ = 0;
};

}  // namespace

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
                          const std::function<void(const SeedOutcome&)>& told) {
  RequireInRange("seeds", options.seeds, 1, 100'000);
  RequireInRange("threads", options.threads, 1, 64);
  if (!scenario.is_lockstep()) {
    throw InputError("seeds: runs of many seeds take drive: lockstep");
  }
  Runs runs(scenario, catalogue, files, clock, options);
  runs.First();
  const int threads = std::min(options.threads, options.seeds);
  std::vector<std::jthread> workers;
  workers.reserve(static_cast<std::size_t>(threads));
  for (int i = 0; i < threads; ++i) workers.emplace_back([&runs] { runs.Work(); });
  runs.Tell(threads, told);
  workers.clear();
  return runs.Result();
}

}  // namespace twin::application
