#include "experiment/loop_runs.h"

#include <cmath>
#include <numeric>
#include <variant>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "twin/core/error.h"

namespace twin::experiment {
namespace {

constexpr double kSlowDriftPpm = 5;  ///< at which the start phase shows
constexpr int kMostSeeds = 3;

/// A quantity that is varied.
struct Sweep {
  std::vector<double> values;
  int seeds;
  void (*set)(scenario::Scenario& scenario, double value);
};

std::vector<Sweep> Sweeps(int seeds) {
  const int few = std::min(seeds, kMostSeeds);
  return {
      {{0, 5, 10, 20, 30, 40, 54.6, 70, 85, 100, 109.2},
       few,
       [](scenario::Scenario& s, double ppm) { s.controller.clock_drift_ppm = ppm; }},
      {Steps(13, 80), 1,
       [](scenario::Scenario& s, double phase_us) {
         s.controller.clock_drift_ppm = kSlowDriftPpm;
         s.controller.phase = FromSeconds(1e-6 * phase_us);
       }},
      {{0.25, 0.5, 1, 1.5, 2, 3, 4}, std::min(few, 2), [](scenario::Scenario& s, double factor) {
         s.controller.cost = Scaled(s.controller.cost, factor);
       }}};
}

faults::EmpiricalDelay& LinkLawOf(scenario::Scenario& s) {
  return std::get<faults::EmpiricalDelay>(s.link.state.delay.law);
}

/// The weight and the place of the late states.
std::vector<Sweep> LateSweeps(int seeds) {
  const int few = std::min(seeds, 2);
  return {{{0, 0.09, 0.18, 0.36, 0.54},
           few,
           [](scenario::Scenario& s, double percent) {
             std::vector<double>& weights = LinkLawOf(s).weights;
             const double others = std::accumulate(weights.begin(), weights.end() - 1, 0.0);
             weights.back() = others * percent / (100 - percent);
           }},
          {{250, 400, 550, 700, 850}, few, [](scenario::Scenario& s, double begin_us) {
             std::vector<Duration>& edges = LinkLawOf(s).edges;
             Duration& begin = edges[edges.size() - 2];
             edges.back() += FromSeconds(1e-6 * begin_us) - begin;
             begin = FromSeconds(1e-6 * begin_us);
           }}};
}

/// Unserved share of a run at a value of the sweep, in %.
double Unserved(const Config& config, scenario::Scenario scenario, const Sweep& sweep,
                double value) {
  sweep.set(scenario, value);
  return SampleLoop(config, scenario).counts.unserved_percent();
}

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
    if (record::WroteCommand(tick)) {
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

LoopRuns RunLoops(const Config& config, const run::Catalogue& stack) {
  LoopRuns runs;
  Grid<LoopSample> samples =
      MapGrid(config, config.seeds, runs.size(), [&](std::size_t run, std::size_t loop) {
        return RunLoop(config, stack, loop, static_cast<int>(run));
      });
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

Figure LateStatesFigure(const Config& config) {
  const std::vector<Sweep> sweeps = LateSweeps(config.seeds);
  Figure figure{.id = "late_states",
                .columns =
                    "varied: 0 weight [%]; 1 begin [us],value,LF unserved [%],RS unserved [%],RA "
                    "unserved [%]"};
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    for (const double value : sweeps[i].values) figure.rows.push_back(Row(i, value));
  }
  const Grid<double> unserved = MapGrid(
      config, figure.rows.size(), kCalibratedLoops.size(), [&](std::size_t row, std::size_t loop) {
        const Sweep& sweep = sweeps[figure.rows[row][0] == 0 ? 0 : 1];
        double sum = 0;
        for (int run = 0; run < sweep.seeds; ++run) {
          sum += Unserved(config, LoopScenario(config, loop, run), sweep, figure.rows[row][1]);
        }
        return sum / sweep.seeds;
      });
  for (std::size_t i = 0; i < figure.rows.size(); ++i) {
    figure.rows[i].insert(figure.rows[i].end(), unserved[i].begin(), unserved[i].end());
  }
  return figure;
}

Figure SensitivityFigure(const Config& config) {
  Figure figure{.id = "sensitivity",
                .columns =
                    "varied: 0 drift [ppm]; 1 phase [us]; 2 load [1],value,mean unserved "
                    "[%],lowest [%],highest [%]",
                .tables = {{"single", {.columns = "varied,value,unserved [%]"}}}};
  const std::vector<Sweep> sweeps = Sweeps(config.seeds);
  const double share = 1 / static_cast<double>(sweeps.size());
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    const Sweep& sweep = sweeps[i];
    const double from = share * static_cast<double>(i);
    const Grid<double> unserved =
        MapGrid(PartOf(config, from, from + share), sweep.values.size(), sweep.seeds,
                [&](std::size_t value, std::size_t seed) {
                  const int run = static_cast<int>(seed);
                  scenario::Scenario scenario = LoadScenario(config, "synchronous", run);
                  scenario.controller.phase = PhaseOfRun(config, run);
                  return Unserved(config, std::move(scenario), sweep, sweep.values[value]);
                });
    for (std::size_t v = 0; v < sweep.values.size(); ++v) {
      const Spread spread = SpreadOf(unserved[v]);
      figure.rows.push_back(Row(i, sweep.values[v], spread.mean, spread.low, spread.high));
      for (const double run : unserved[v]) {
        figure.tables["single"].rows.push_back(Row(i, sweep.values[v], run));
      }
    }
  }
  return figure;
}

}  // namespace twin::experiment
