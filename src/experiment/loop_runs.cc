#include "experiment/loop_runs.h"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "twin/core/error.h"
#include "twin/experiment/calibration.h"

namespace twin::experiment {
namespace {

LoopSample RunOnce(const Setting& setting, const run::Catalogue& stack, std::size_t loop, int run) {
  const scenario::Scenario scenario = LoopScenario(setting, loop, run);
  const bool is_bare = scenario.loop == loop::LoopKind::kBare;
  LoopSample sample = SampleLoop(is_bare ? setting : With(setting, stack), scenario);
  if (!sample.d_EXT_us.empty() && !sample.interval_us.empty() && sample.cycles > 0) return sample;
  throw InputError(fmt::format(
      "{}.yaml: in a run of it the robot never had a command in time{}{}; {}",
      CalibratedLoops()[loop].file, sample.failure.empty() ? "" : ": ", sample.failure,
      setting.on_wall_clock ? "this machine gives its threads no time (see panda-twin check)"
                            : "its delays leave no cycle served"));
}

}  // namespace

scenario::Scenario LoopScenario(const Setting& setting, std::size_t loop, int run) {
  scenario::Scenario scenario = LoadScenario(setting, CalibratedLoops()[loop].file);
  scenario.seed = SeedOfRun(setting, run);
  if (scenario.loop != loop::LoopKind::kBare) {  // which has no clock of its own
    scenario.controller.phase =
        FromSeconds(kCycleSeconds * ChoiceOfRun(setting, run, static_cast<std::uint32_t>(loop)));
  }
  return scenario;
}

LoopRuns RunLoops(const Setting& setting, const run::Catalogue& stack, double share) {
  LoopRuns runs;
  for (auto& samples : runs) samples.resize(static_cast<std::size_t>(setting.seeds));
  const auto work = [&](int job) {
    const std::size_t loop = static_cast<std::size_t>(job) % runs.size();
    const int run = job / static_cast<int>(runs.size());
    runs[loop][static_cast<std::size_t>(run)] = RunOnce(setting, stack, loop, run);
  };
  InParallel(setting, setting.seeds * static_cast<int>(runs.size()), work, 0, share);
  return runs;
}

}  // namespace twin::experiment
