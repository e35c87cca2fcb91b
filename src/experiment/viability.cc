#include "experiment/viability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/convergence.h"
#include "experiment/hostile_source.h"
#include "experiment/runs.h"
#include "experiment/stream.h"
#include "experiment/viability_runs.h"
#include "experiment/viable_set.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment {
namespace {

constexpr std::array<Disturbance, 3> kDisturbances{Disturbance::kThread, Disturbance::kBursts,
                                                   Disturbance::kCalibrated};
constexpr std::array<Maker, 2> kMakers{Maker::kOurs, Maker::kPaper};

std::string_view NameOf(Disturbance disturbance) {
  switch (disturbance) {
    case Disturbance::kThread: return "4 us jitter, 50 ppm, 0.41 % lost";
    case Disturbance::kBursts: return "4 us jitter, 50 ppm, bursts of 19";
    case Disturbance::kCalibrated: return "calibrated loop";
  }
  return {};
}

/// The runs of one tempo and one disturbance, by maker.
struct Pair {
  Tempo tempo;
  Disturbance disturbance = Disturbance::kThread;
  std::array<std::vector<ViabilityRun>, kMakers.size()> runs;

  [[nodiscard]] const std::vector<ViabilityRun>& ours() const { return runs[0]; }
  [[nodiscard]] const std::vector<ViabilityRun>& paper() const { return runs[1]; }
};

std::vector<Pair> RunAll(const Setting& setting, int runs) {
  std::vector<Pair> pairs;
  for (const Tempo& tempo : kTempos) {
    for (const Disturbance disturbance : kDisturbances) {
      pairs.push_back({.tempo = tempo, .disturbance = disturbance, .runs = {}});
      for (auto& of_maker : pairs.back().runs) of_maker.resize(static_cast<std::size_t>(runs));
    }
  }
  const int per_pair = runs * static_cast<int>(kMakers.size());
  InParallel(
      setting, static_cast<int>(pairs.size()) * per_pair,
      [&](int job) {
        Pair& pair = pairs[static_cast<std::size_t>(job / per_pair)];
        const auto maker = static_cast<std::size_t>(job % per_pair / runs);
        const int run = job % runs;
        pair.runs.at(maker)[static_cast<std::size_t>(run)] = RunViabilityCase(
            setting,
            {.tempo = pair.tempo, .disturbance = pair.disturbance, .maker = kMakers.at(maker)},
            run);
      },
      0.3, 1);
  return pairs;
}

double AbortedPercent(const std::vector<ViabilityRun>& runs) {
  const auto aborted = std::ranges::count_if(runs, &ViabilityRun::aborted);
  return 100.0 * static_cast<double>(aborted) / static_cast<double>(runs.size());
}

/// Of each run a number: the worst, and the range.
template <class Number>
Comparison WorstOf(const std::vector<ViabilityRun>& runs, bool largest, const Number& number) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const ViabilityRun& run : runs) values.push_back(number(run));
  const auto [low, high] = std::ranges::minmax(values);
  return {.ours = largest ? high : low, .low = low, .high = high};
}

/// How much more power ours has in the band than the paper's generator in the same runs, of those
/// that the latter completes: worst joint. Not a number when there are none.
double BandRatio(const Pair& pair) {
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t j = 0; j < kJoints; ++j) {
    double ours = 0;
    double paper = 0;
    for (std::size_t run = 0; run < pair.paper().size(); ++run) {
      if (pair.paper()[run].aborted) continue;
      ours += pair.ours()[run].band[j];
      paper += pair.paper()[run].band[j];
    }
    if (paper > 0) worst = std::fmax(worst, ours / paper);
  }
  return worst;
}

void Demand(Comparison comparison, std::string quantity, std::string unit, std::string demand,
            bool met, Findings& findings) {
  comparison.quantity = std::move(quantity);
  comparison.unit = std::move(unit);
  comparison.demand = std::move(demand);
  comparison.verdict = comparison.demand.empty() ? Verdict::kReported : Judge(met);
  findings.comparisons.push_back(std::move(comparison));
}

/// What must hold of one tempo and one disturbance.
void ComparePair(const Pair& pair, Findings& findings) {
  const std::string name = fmt::format("{}, {}: ", pair.tempo.name, NameOf(pair.disturbance));
  const double aborted = AbortedPercent(pair.ours());
  Demand({.ours = aborted}, name + "ours aborted", "%", "none", aborted == 0, findings);
  Demand({.ours = AbortedPercent(pair.paper())}, name + "the paper's generator aborted", "%", "",
         true, findings);
  // Bursts are no admissible reference, and a source near its limits leaves no room to rejoin.
  const bool is_smooth = pair.tempo.stretch == 0 && pair.disturbance != Disturbance::kBursts;
  const auto demanded = [is_smooth](const char* text) {
    return std::string(is_smooth ? text : "");
  };
  Comparison idle =
      WorstOf(pair.ours(), false, [](const ViabilityRun& run) { return run.idle_percent; });
  const bool is_idle = idle.ours >= 99;
  Demand(std::move(idle), name + "commands that the filter let pass", "%",
         demanded("at least 99 in every run"), is_idle, findings);
  Comparison rms =
      WorstOf(pair.ours(), true, [](const ViabilityRun& run) { return 1e3 * run.rms; });
  const bool is_near = rms.ours <= 2;
  Demand(std::move(rms), name + "RMS error less its delay, worst joint", "mrad",
         demanded("at most 2 in every run"), is_near, findings);
  Demand(WorstOf(pair.ours(), true, [](const ViabilityRun& run) { return 1e3 * run.delay_s; }),
         name + "delay", "ms", "", true, findings);
  Demand(WorstOf(pair.ours(), false, [](const ViabilityRun& run) { return run.least_margin; }),
         name + "least margin", "", "", true, findings);
  const double ratio = BandRatio(pair);
  Demand({.ours = ratio},
         name + "power of dq_d in 20 to 150 Hz over that of the paper's generator, worst joint", "",
         demanded(std::isnan(ratio) ? "" : "at most 2"), ratio <= 2, findings);
}

/// The least of the joints' margins over a trajectory under bursts, at each tempo.
Figure MarginFigure(const std::vector<Pair>& pairs) {
  constexpr std::size_t kEvery = 5;
  Figure figure{.id = "margin",
                .columns = "stretch of the brisk trajectory [-],t [s],margin [-],kept back [bits]"};
  for (const Pair& pair : pairs) {
    if (pair.disturbance != Disturbance::kBursts) continue;
    figure.names.emplace_back(pair.tempo.name);
    const ViabilityRun& run = pair.ours().front();
    for (std::size_t k = 0; k < run.ticks.size(); ++k) {
      const TickSample& tick = run.ticks[k];
      if (k % kEvery != 0 && tick.kept_back == 0) continue;
      const auto cycle = static_cast<double>(tick.message_id - run.ticks.front().message_id);
      figure.rows.push_back({pair.tempo.stretch, cycle * kCycleSeconds, tick.margin.value_or(0),
                             static_cast<double>(tick.kept_back)});
    }
  }
  return figure;
}

Figure SpectrumFigure(const Pair& pair) {
  Figure figure{.id = "spectrum",
                .columns = "f [Hz],ours [(rad/s)^2/Hz],the paper's generator [(rad/s)^2/Hz]"};
  const Spectrum& ours = pair.ours().front().spectrum;
  const Spectrum& paper = pair.paper().front().spectrum;
  for (std::size_t i = 1; i < std::min(ours.density.size(), paper.density.size()); ++i) {
    figure.rows.push_back({ours.frequency_hz(i), ours.density[i], paper.density[i]});
  }
  return figure;
}

}  // namespace

Findings RunViability(const Setting& setting) {
  const int runs = std::min(setting.seeds, 6);
  const StreamSetting streams = LoadStreamSetting(setting);
  Findings findings{.values = {{"runs", fmt::format("{}", runs)}}};
  std::vector<reference::AxisBounds> bounds;
  bounds.reserve(kJoints);
  for (std::size_t i = 0; i < kJoints; ++i) {
    bounds.push_back(reference::BoundsOf(streams.robot.limits, i));
  }
  AddViableSet(bounds, findings);
  AddConvergence(streams.robot, findings);
  AddHostileSource(streams.robot, findings);
  if (setting.progress) setting.progress(0.3);
  const std::vector<Pair> pairs = RunAll(setting, runs);
  for (const Pair& pair : pairs) ComparePair(pair, findings);
  findings.figures.push_back(SpectrumFigure(pairs.front()));
  findings.figures.push_back(MarginFigure(pairs));
  return findings;
}

}  // namespace twin::experiment
