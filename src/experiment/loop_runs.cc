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

/// Collects the times of the ticks.
class TickTimes final : public record::RecordSink {
 public:
  TickTimes() {
    // On the wall clock a run allocates nothing: half a minute fits.
    sample.interval_us.reserve(kTicks);
    sample.d_EXT_us.reserve(kTicks);
  }
  void Put(const record::CycleRecord& /*record*/) noexcept override {}
  void Put(const record::TickRecord& record) noexcept override {
    if (last_read_) sample.interval_us.push_back(1e6 * ToSeconds(record.read - *last_read_));
    last_read_ = record.read;
    if (record.action == record::TickAction::kWritten ||
        record.action == record::TickAction::kFinished) {
      sample.d_EXT_us.push_back(1e6 * ToSeconds(record.written - record.read));
    }
  }

  LoopSample sample;

 private:
  static constexpr std::size_t kTicks = 32768;

  std::optional<Time> last_read_;
};

LoopSample RunLoop(const Config& config, const run::Catalogue& stack, std::size_t loop, int run) {
  const scenario::Scenario scenario = LoopScenario(config, loop, run);
  Config with_stack = config;
  if (scenario.loop != loop::LoopKind::kBare) with_stack.catalogue = stack;
  LoopSample sample = SampleLoop(with_stack, scenario);
  if (!sample.d_EXT_us.empty() && !sample.interval_us.empty() && sample.cycles > 0) return sample;
  throw InputError(fmt::format(
      "{}.yaml: in one of its runs the robot never had a command in time{}{}; {}",
      CalibratedLoops()[loop].file, sample.failure.empty() ? "" : ": ", sample.failure,
      config.on_wall_clock ? "this machine gives its threads no time (see panda-twin check)"
                           : "its delays leave no cycle served"));
}

}  // namespace

LoopSample SampleLoop(const Config& config, const scenario::Scenario& scenario) {
  TickTimes times;
  const run::RunResult result = RunScenario(config, scenario, &times);
  LoopSample& sample = times.sample;
  std::ranges::sort(sample.d_EXT_us);
  const auto& counts = result.counts;
  sample.cycles = counts.cycles();
  sample.unserved_percent = counts.unserved_percent();
  sample.longest_loss = counts.longest_loss;
  sample.succeeded = result.report.succeeded();
  sample.failure = result.report.failure;
  const backend::RobotTimings& robot = result.report.robot_timings;
  sample.robot_late_p99_us = 1e6 * ToSeconds(robot.lateness.Percentile(0.99));
  sample.robot_overruns = robot.overruns;
  return std::move(sample);
}

scenario::Scenario LoopScenario(const Config& config, std::size_t loop, int run) {
  scenario::Scenario scenario = LoadScenario(config, CalibratedLoops()[loop].file);
  scenario.seed = SeedOfRun(config, run);
  if (scenario.loop != loop::LoopKind::kBare) {  // which has no clock of its own
    scenario.controller.phase = PhaseOfRun(config, run, static_cast<std::uint32_t>(loop));
  }
  return scenario;
}

LoopRuns RunLoops(const Config& config, const run::Catalogue& stack, double share) {
  constexpr int kLoops = std::tuple_size_v<LoopRuns>;
  std::vector<LoopSample> samples = MapInParallel(
      config, config.seeds * kLoops,
      [&](int job) { return RunLoop(config, stack, job % kLoops, job / kLoops); }, 0, share);
  LoopRuns runs;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    runs[i % kLoops].push_back(std::move(samples[i]));
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
