#include "twin/application/seed_run.h"

#include "twin/core/clock.h"
#include "twin/run/run_records.h"

namespace twin::application {

SeedOutcome RunSeed(scenario::Scenario scenario, std::uint64_t seed,
                    const run::Catalogue& catalogue, const run::RunFiles& files,
                    const volatile bool* interrupted) {
  const MonotonicClock clock;
  scenario.seed = seed;
  run::RunRecords records;
  ApplicationRun run(scenario, catalogue, files, &records, clock);
  if (const auto* truth = run.connection().truth) records.WatchContacts(*truth);
  run::RunHooks hooks;
  hooks.interrupted = interrupted;
  const TaskResult& task_result = run.Execute(hooks);
  const Evaluation& evaluation =
      run.Evaluate({.log = {}, .contacts = records.contacts() ? &*records.contacts() : nullptr});
  SeedOutcome outcome{.seed = seed,
                      .failure = FailureOf(task_result, evaluation),
                      .findings = evaluation.findings,
                      .counts = run.session_result().counts,
                      .states_hash = run.session_result().states_hash};
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

}  // namespace twin::application
