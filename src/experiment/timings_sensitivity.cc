#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>
#include <variant>
#include <vector>

#include "experiment/loop_runs.h"
#include "experiment/runs.h"
#include "experiment/timings_figures.h"
#include "twin/core/check.h"
#include "twin/core/time.h"
#include "twin/experiment/calibration.h"

namespace twin::experiment {
namespace {

constexpr double kSlowDriftPpm = 5;  ///< at which the start phase shows
constexpr int kMostSeeds = 3;

/// What is varied.
struct Sweep {
  std::vector<double> values;
  int seeds;
  std::function<void(scenario::Scenario&, double value)> set;
};

std::vector<double> Steps(double from, double to, int count) {
  std::vector<double> values(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    values[static_cast<std::size_t>(i)] = from + (to - from) * i / (count - 1);
  }
  return values;
}

std::array<Sweep, 3> Sweeps(int seeds) {
  const int few = std::min(seeds, kMostSeeds);
  return {{
      {{0, 5, 10, 20, 30, 40, 54.6, 70, 85, 100, 109.2},
       few,
       [](scenario::Scenario& s, double ppm) { s.controller.clock_drift_ppm = ppm; }},
      {Steps(0, 960, 13), 1,
       [](scenario::Scenario& s, double phase_us) {
         s.controller.clock_drift_ppm = kSlowDriftPpm;
         s.controller.phase = FromSeconds(1e-6 * phase_us);
       }},
      {{0.25, 0.5, 1, 1.5, 2, 3, 4},
       std::min(few, 2),
       [](scenario::Scenario& s, double factor) {
         s.controller.cost = Scaled(s.controller.cost, factor);
       }},
  }};
}

/// Unserved share of each value's runs, in %.
std::vector<std::vector<double>> RunSweep(const Setting& setting, const Sweep& sweep, double from,
                                          double to) {
  const scenario::Scenario base = LoadScenario(setting, "synchronous");
  std::vector<std::vector<double>> unserved(sweep.values.size());
  for (auto& runs : unserved) runs.resize(static_cast<std::size_t>(sweep.seeds));
  const auto work = [&](int job) {
    const int run = job % sweep.seeds;
    const auto value = static_cast<std::size_t>(job / sweep.seeds);
    scenario::Scenario scenario = base;
    scenario.seed = SeedOfRun(setting, run);
    scenario.controller.phase = FromSeconds(kCycleSeconds * ChoiceOfRun(setting, run));
    sweep.set(scenario, sweep.values[value]);
    unserved[value][static_cast<std::size_t>(run)] = SampleLoop(setting, scenario).unserved_percent;
  };
  InParallel(setting, static_cast<int>(sweep.values.size()) * sweep.seeds, work, from, to);
  return unserved;
}

/// What is varied of the late states: a panel.
struct LateStates {
  std::vector<double> values;
  void (*set)(rt::EmpiricalDelay& law, double value);
};

const std::array<LateStates, 2>& LateStatesPanels() {
  static const std::array<LateStates, 2> panels{
      {{{0, 0.09, 0.18, 0.36, 0.54},
        [](rt::EmpiricalDelay& law, double percent) {
          double others = 0;
          for (std::size_t i = 0; i + 1 < law.weights.size(); ++i) others += law.weights[i];
          law.weights.back() = others * percent / (100 - percent);
        }},
       {{250, 400, 550, 700, 850}, [](rt::EmpiricalDelay& law, double begin_us) {
          Duration& begin = law.edges[law.edges.size() - 2];
          law.edges.back() += FromSeconds(1e-6 * begin_us) - begin;
          begin = FromSeconds(1e-6 * begin_us);
        }}}};
  return panels;
}

/// Unserved share of a loop whose states come late so, the mean of some runs, in %.
double UnservedOf(const Setting& setting, std::size_t loop, const LateStates& what, double value,
                  int runs) {
  double sum = 0;
  for (int run = 0; run < runs; ++run) {
    scenario::Scenario scenario = LoopScenario(setting, loop, run);
    auto* law = std::get_if<rt::EmpiricalDelay>(&scenario.link.state.delay.law);
    TWIN_CHECK(law != nullptr);
    what.set(*law, value);
    sum += SampleLoop(setting, scenario).unserved_percent;
  }
  return sum / runs;
}

}  // namespace

Figure LateStatesFigure(const Setting& setting, double from, double to) {
  const auto& panels = LateStatesPanels();
  const std::array<CalibratedLoop, 3>& loops = CalibratedLoops();
  const std::size_t values = panels[0].values.size();
  std::vector<std::vector<double>> rows(panels.size() * values);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t panel = i / values;
    rows[i] = {static_cast<double>(panel), panels.at(panel).values[i % values], 0, 0, 0};
  }
  const int runs = std::min(setting.seeds, 2);
  const auto work = [&](int job) {
    const std::size_t loop = static_cast<std::size_t>(job) % loops.size();
    const std::size_t row = static_cast<std::size_t>(job) / loops.size();
    rows[row][2 + loop] = UnservedOf(setting, loop, panels.at(row / values), rows[row][1], runs);
  };
  InParallel(setting, static_cast<int>(rows.size() * loops.size()), work, from, to);
  return {.id = "late_states",
          .columns =
              "varied: 0 weight [%]; 1 begin [us],value,LF unserved [%],RS unserved [%],RA "
              "unserved [%]",
          .rows = std::move(rows)};
}

Figure SensitivityFigure(const Setting& setting, double from) {
  Figure figure{.id = "sensitivity",
                .columns =
                    "varied: 0 drift [ppm]; 1 phase [us]; 2 load [1],value,mean unserved "
                    "[%],lowest [%],highest [%]",
                .tables = {{"single", {.columns = "varied,value,unserved [%]"}}}};
  const std::array<Sweep, 3> sweeps = Sweeps(setting.seeds);
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    const Sweep& sweep = sweeps[i];
    const double share = (1 - from) / static_cast<double>(sweeps.size());
    const auto unserved = RunSweep(setting, sweep, from + share * static_cast<double>(i),
                                   from + share * static_cast<double>(i + 1));
    for (std::size_t v = 0; v < sweep.values.size(); ++v) {
      const Spread spread = SpreadOf(unserved[v]);
      const auto varied = static_cast<double>(i);
      figure.rows.push_back({varied, sweep.values[v], spread.mean, spread.low, spread.high});
      for (const double run : unserved[v]) {
        figure.tables["single"].rows.push_back({varied, sweep.values[v], run});
      }
    }
  }
  return figure;
}

}  // namespace twin::experiment
