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
#include "twin/report/chart.h"

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

std::string_view NameOf(Maker maker) {
  return maker == Maker::kOurs ? "rejoining generator, filter" : "the paper's generator";
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

report::ChartPanel MarginPanel(const Pair& pair, Figure& figure) {
  constexpr std::size_t kEvery = 5;
  const ViabilityRun& run = pair.ours().front();
  report::ChartPanel panel{.title = fmt::format("{}, bursts of 19", pair.tempo.name),
                           .x_label = "t [s]",
                           .y_label = "least margin",
                           .y_range = {{-0.05, 0.5}}};
  const bool has_key = figure.rows.empty();
  report::ChartCurve margin{.name = has_key ? "margin" : "", .colour = report::colour::kSeries[0]};
  report::ChartCurve kept_back{.name = "kept back",
                               .colour = report::colour::kSeries[2],
                               .style = report::ChartCurve::Style::kPoints};
  for (std::size_t k = 0; k < run.ticks.size(); ++k) {
    const TickSample& tick = run.ticks[k];
    const double t =
        static_cast<double>(tick.message_id - run.ticks.front().message_id) * kCycleSeconds;
    margin.x.push_back(t);
    margin.y.push_back(tick.margin.value_or(0));
    if (tick.kept_back != 0) {
      kept_back.x.push_back(t);
      kept_back.y.push_back(0);
    }
    if (k % kEvery == 0 || tick.kept_back != 0) {
      figure.rows.push_back(
          {pair.tempo.stretch, t, tick.margin.value_or(0), static_cast<double>(tick.kept_back)});
    }
  }
  panel.curves = {std::move(margin)};
  if (!kept_back.x.empty()) panel.curves.push_back(std::move(kept_back));
  return panel;
}

Figure DrawMargins(const std::vector<Pair>& pairs) {
  Figure figure{.id = "margin",
                .title = "Margin over a trajectory",
                .what =
                    "The least of the joints' margins to the border of the viable set, in the "
                    "state that each command answers. At rest it is what the position leaves; "
                    "a burst that is held at full acceleration takes most of it.",
                .svg = {},
                .columns = "stretch of the brisk trajectory [-],t [s],margin [-],kept back [bits]",
                .rows = {}};
  report::Chart chart{
      .title = figure.title, .columns = 1, .width = 1000, .panel_height = 240, .panels = {}};
  for (const Pair& pair : pairs) {
    if (pair.disturbance == Disturbance::kBursts) {
      chart.panels.push_back(MarginPanel(pair, figure));
    }
  }
  figure.svg = report::DrawChart(chart);
  return figure;
}

Figure DrawSpectra(const Pair& pair) {
  Figure figure{.id = "spectrum",
                .title = "Smooth, not only legal: joint 1 on the canonical trajectory",
                .what =
                    "Power spectral density of the reference's velocity behind the asynchronous "
                    "thread's timing.",
                .svg = {},
                .columns = "f [Hz],ours [(rad/s)^2/Hz],the paper's generator [(rad/s)^2/Hz]",
                .rows = {}};
  report::ChartPanel panel{.title = std::string(NameOf(pair.disturbance)),
                           .x_label = "f [Hz]",
                           .y_label = "PSD of dq_d [(rad/s)^2/Hz]",
                           .log_x = true,
                           .log_y = true};
  for (std::size_t m = 0; m < kMakers.size(); ++m) {
    panel.curves.push_back(
        {.name = std::string(NameOf(kMakers.at(m))), .colour = report::colour::kSeries.at(m)});
  }
  const Spectrum& ours = pair.ours().front().spectrum;
  const Spectrum& paper = pair.paper().front().spectrum;
  for (std::size_t i = 1; i < std::min(ours.density.size(), paper.density.size()); ++i) {
    figure.rows.push_back({ours.frequency_hz(i), ours.density[i], paper.density[i]});
    for (std::size_t m = 0; m < kMakers.size(); ++m) {
      panel.curves[m].x.push_back(figure.rows.back()[0]);
      panel.curves[m].y.push_back(figure.rows.back()[1 + m]);
    }
  }
  figure.svg = report::DrawChart({.title = figure.title, .panels = {std::move(panel)}});
  return figure;
}

std::string Describe(int runs) {
  return fmt::format(
      "A filter behind everything else keeps the joints' limits of position, velocity, "
      "acceleration "
      "and jerk for ever, whatever up to n commands in a row are lost. First the set of states it "
      "keeps to, by its closed form: borders and price. Speeds, ways to stop and times that are "
      "demanded are those of another implementation, made before this one. Then what becomes of an "
      "offset when every command is taken: time, overshoot, shares of the limits; a share above 1 "
      "is a motion that the robot would have aborted, looked at all the same. Then motions on the "
      "ideal plant behind the asynchronous thread's timing, {} runs of each, with start phases "
      "that differ, the client's limiter off; error and power are of the reference q_d. The "
      "calibrated loop is that of Table 1, whose losses are states that come late.",
      runs);
}

}  // namespace

Findings RunViability(const Setting& setting) {
  const int runs = std::min(setting.seeds, 6);
  const StreamSetting streams = LoadStreamSetting(setting);
  Findings findings{.id = "viability",
                    .title = "Legal for ever, whatever is lost",
                    .source = "left open by the paper (its outlook)",
                    .text = Describe(runs)};
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
  findings.figures.push_back(DrawSpectra(pairs.front()));
  findings.figures.push_back(DrawMargins(pairs));
  return findings;
}

}  // namespace twin::experiment
