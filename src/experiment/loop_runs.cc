#include "experiment/loop_runs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "twin/core/error.h"

namespace twin::experiment {
namespace {

LoopSample RunLoop(const Config& config, const run::Catalogue& stack, std::size_t loop, int run) {
  const scenario::Scenario scenario = LoopScenario(config, loop, run);
  Config with_stack = config;
  if (scenario.loop != loop::LoopKind::kBare) with_stack.catalogue = stack;
  LoopSample sample = SampleLoop(with_stack, scenario);
  if (!sample.d_EXT_us.empty() && !sample.interval_us.empty() && sample.counts.cycles() > 0)
    return sample;
  throw InputError(fmt::format(
      "{}.yaml: in one of its runs the robot never had a command in time{}{}; {}",
      kCalibratedLoops[loop].file, sample.failure.empty() ? "" : ": ", sample.failure,
      config.on_wall_clock ? "this machine gives its threads no time (see panda-twin check)"
                           : "its delays leave no cycle served"));
}

}  // namespace

LoopSample SampleLoop(const Config& config, const scenario::Scenario& scenario) {
  LoopSample sample;
  sample.interval_us.reserve(kMostRecords);
  sample.d_EXT_us.reserve(kMostRecords);
  std::optional<Time> last_read;
  SinkTo ticks([&](const record::TickRecord& tick) {
    if (last_read) sample.interval_us.push_back(1e6 * ToSeconds(tick.read - *last_read));
    last_read = tick.read;
    if (tick.action == record::TickAction::kWritten ||
        tick.action == record::TickAction::kFinished) {
      sample.d_EXT_us.push_back(1e6 * ToSeconds(tick.written - tick.read));
    }
  });
  const run::RunResult result = RunScenario(config, scenario, &ticks);
  std::ranges::sort(sample.d_EXT_us);
  sample.counts = result.counts;
  sample.succeeded = result.report.succeeded();
  sample.failure = result.report.failure;
  const backend::RobotTimings& robot = result.report.robot_timings;
  sample.robot_late_p99_us = 1e6 * ToSeconds(robot.lateness.Percentile(0.99));
  sample.robot_overruns = robot.overruns;
  return sample;
}

scenario::Scenario LoopScenario(const Config& config, std::size_t loop, int run) {
  scenario::Scenario scenario = LoadScenario(config, kCalibratedLoops[loop].file, run);
  if (scenario.loop != loop::LoopKind::kBare) {  // which has no clock of its own
    scenario.controller.phase = PhaseOfRun(config, run, static_cast<std::uint32_t>(loop));
  }
  return scenario;
}

LoopRuns RunLoops(const Config& config, const run::Catalogue& stack, double share) {
  Grid<LoopSample> samples = MapGrid(
      config, config.seeds, std::tuple_size_v<LoopRuns>,
      [&](std::size_t run, std::size_t loop) {
        return RunLoop(config, stack, loop, static_cast<int>(run));
      },
      0, share);
  LoopRuns runs;
  for (std::size_t i = 0; i < samples.all.size(); ++i) {
    runs[i % runs.size()].push_back(std::move(samples.all[i]));
  }
  return runs;
}

scenario::Delay Scaled(const scenario::Delay& delay, double factor) {
  scenario::Delay scaled = delay;
  const auto scale = [factor](auto&... durations) {
    ((durations = Duration(std::llround(factor * static_cast<double>(durations.count())))), ...);
  };
  if (auto* constant = std::get_if<faults::ConstantDelay>(&scaled.law)) {
    scale(constant->value);
  } else if (auto* log_normal = std::get_if<faults::LogNormalDelay>(&scaled.law)) {
    scale(log_normal->median, log_normal->offset);
  } else if (auto* normal = std::get_if<faults::NormalDelay>(&scaled.law)) {
    scale(normal->mean, normal->sigma);
  } else if (auto* gamma = std::get_if<faults::GammaDelay>(&scaled.law)) {
    scale(gamma->scale, gamma->offset);
  } else {
    for (Duration& edge : std::get<faults::EmpiricalDelay>(scaled.law).edges) scale(edge);
  }
  return scaled;
}

}  // namespace twin::experiment
