#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>
#include <variant>
#include <vector>

#include "experiment/loop_runs.h"
#include "experiment/runs.h"
#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::experiment {
namespace {

constexpr double kSlowDriftPpm = 5;  ///< at which the start phase shows
constexpr int kMostSeeds = 3;

/// A quantity that is varied.
struct Sweep {
  std::vector<double> values;
  int seeds;
  std::function<void(scenario::Scenario&, double value)> set;
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

/// Unserved share of each run in %, a row for each value.
Grid<double> RunSweep(const Config& config, const Sweep& sweep, double from, double to) {
  return MapGrid(
      config, sweep.values.size(), sweep.seeds,
      [&](std::size_t value, std::size_t seed) {
        const int run = static_cast<int>(seed);
        scenario::Scenario scenario = LoadScenario(config, "synchronous", run);
        scenario.controller.phase = PhaseOfRun(config, run);
        sweep.set(scenario, sweep.values[value]);
        return SampleLoop(config, scenario).counts.unserved_percent();
      },
      from, to);
}

/// A panel of the late states: their weight or their place.
struct LateStates {
  std::vector<double> values;
  void (*set)(faults::EmpiricalDelay& law, double value);
};

std::vector<LateStates> LateStatesPanels() {
  return {{{0, 0.09, 0.18, 0.36, 0.54},
           [](faults::EmpiricalDelay& law, double percent) {
             double others = 0;
             for (std::size_t i = 0; i + 1 < law.weights.size(); ++i) others += law.weights[i];
             law.weights.back() = others * percent / (100 - percent);
           }},
          {{250, 400, 550, 700, 850}, [](faults::EmpiricalDelay& law, double begin_us) {
             Duration& begin = law.edges[law.edges.size() - 2];
             law.edges.back() += FromSeconds(1e-6 * begin_us) - begin;
             begin = FromSeconds(1e-6 * begin_us);
           }}};
}

/// Unserved share of a loop with such late states, the mean of some runs, in %.
double UnservedOf(const Config& config, std::size_t loop, const LateStates& what, double value,
                  int runs) {
  double sum = 0;
  for (int run = 0; run < runs; ++run) {
    scenario::Scenario scenario = LoopScenario(config, loop, run);
    auto* law = std::get_if<faults::EmpiricalDelay>(&scenario.link.state.delay.law);
    TWIN_CHECK(law != nullptr);
    what.set(*law, value);
    sum += SampleLoop(config, scenario).counts.unserved_percent();
  }
  return sum / runs;
}

}  // namespace

Figure LateStatesFigure(const Config& config, double from, double to) {
  const std::vector<LateStates> panels = LateStatesPanels();
  Figure figure{.id = "late_states",
                .columns =
                    "varied: 0 weight [%]; 1 begin [us],value,LF unserved [%],RS unserved [%],RA "
                    "unserved [%]"};
  for (std::size_t panel = 0; panel < panels.size(); ++panel) {
    for (const double value : panels[panel].values) {
      figure.rows.push_back({static_cast<double>(panel), value});
    }
  }
  const Grid<double> unserved = MapGrid(
      config, figure.rows.size(), kCalibratedLoops.size(),
      [&](std::size_t row, std::size_t loop) {
        const LateStates& panel = panels[figure.rows[row][0] == 0 ? 0 : 1];
        return UnservedOf(config, loop, panel, figure.rows[row][1], std::min(config.seeds, 2));
      },
      from, to);
  for (std::size_t i = 0; i < figure.rows.size(); ++i) {
    figure.rows[i].insert(figure.rows[i].end(), unserved[i].begin(), unserved[i].end());
  }
  return figure;
}

Figure SensitivityFigure(const Config& config, double from) {
  Figure figure{.id = "sensitivity",
                .columns =
                    "varied: 0 drift [ppm]; 1 phase [us]; 2 load [1],value,mean unserved "
                    "[%],lowest [%],highest [%]",
                .tables = {{"single", {.columns = "varied,value,unserved [%]"}}}};
  const std::vector<Sweep> sweeps = Sweeps(config.seeds);
  const double share = (1 - from) / static_cast<double>(sweeps.size());
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    const Sweep& sweep = sweeps[i];
    const auto varied = static_cast<double>(i);
    const Grid<double> unserved =
        RunSweep(config, sweep, from + share * varied, from + share * (varied + 1));
    for (std::size_t v = 0; v < sweep.values.size(); ++v) {
      const std::span<const double> runs = unserved[v];
      const Spread spread = SpreadOf(runs);
      figure.rows.push_back({varied, sweep.values[v], spread.mean, spread.low, spread.high});
      for (const double run : runs) {
        figure.tables["single"].rows.push_back({varied, sweep.values[v], run});
      }
    }
  }
  return figure;
}

}  // namespace twin::experiment
