#include "experiment/timings_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/experiment/calibration.h"
#include "twin/report/chart.h"

namespace twin::experiment {
namespace {

using report::ChartCurve;
using report::ChartPanel;

// Places in CalibratedLoops().
constexpr std::size_t kBare = 0;
constexpr std::size_t kSynchronous = 1;
constexpr std::size_t kAsynchronous = 2;

/// A curve of as many points as x; steps hold a bin's share from its lower edge.
ChartCurve CurveOf(std::size_t loop, ChartCurve::Style style, std::vector<double> x,
                   std::vector<double> y) {
  const CalibratedLoop& calibrated = CalibratedLoops()[loop];
  return {.name = std::string(calibrated.name),
          .colour = calibrated.colour,
          .style = style,
          .x = std::move(x),
          .y = std::move(y)};
}

/// One loop's intervals. @param centres_ms  of the bins. @param one  share of a single interval.
ChartPanel IntervalPanel(std::size_t loop, const std::vector<double>& centres_ms,
                         const std::vector<double>& shares, double one) {
  ChartPanel panel{
      .y_label = "share", .log_y = true, .x_range = {{0, 4.4}}, .y_range = {{0.5 * one, 1}}};
  if (loop == kSynchronous) {
    for (const double peak : {1.0, 2.0, 3.0}) {
      panel.curves.push_back({.name = peak == 1 ? "peaks A, B, C: 1, 2, 3 ms" : "",
                              .colour = report::colour::kReference,
                              .style = ChartCurve::Style::kDashed,
                              .x = {peak, peak},
                              .y = {0.5 * one, 1}});
    }
  }
  panel.curves.push_back(CurveOf(loop, ChartCurve::Style::kBars, centres_ms, shares));
  return panel;
}

}  // namespace

std::vector<double> Pooled(const std::vector<LoopSample>& runs,
                           std::vector<double> LoopSample::*key) {
  std::vector<double> pooled;
  for (const LoopSample& run : runs) {
    pooled.insert(pooled.end(), (run.*key).begin(), (run.*key).end());
  }
  return pooled;
}

Figure LatencyFigure(const LoopRuns& runs) {
  const std::vector<double> edges = LogEdges(4, 3000, 40);
  ChartPanel density{.title = "how often",
                     .x_label = "d_EXT [us]",
                     .y_label = "share of commands in a bin [%]",
                     .log_x = true};
  ChartPanel tail{.title = "how often longer",
                  .x_label = "d_EXT [us]",
                  .y_label = "share of commands that took longer",
                  .log_x = true,
                  .log_y = true};
  std::vector<std::vector<double>> rows(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) rows[i] = {edges[i]};
  for (std::size_t loop = 0; loop < runs.size(); ++loop) {
    const std::vector<double> values = Pooled(runs[loop], &LoopSample::d_EXT_us);
    std::vector<double> shares = Histogram(values, edges);
    shares.push_back(0);
    for (double& share : shares) share *= 100;
    const std::vector<double> above = Exceedance(values, edges);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      rows[i].insert(rows[i].end(), {shares[i], above[i]});
    }
    density.curves.push_back(CurveOf(loop, ChartCurve::Style::kSteps, edges, shares));
    tail.curves.push_back(CurveOf(loop, ChartCurve::Style::kLine, edges, above));
  }
  return {
      .id = "d_ext",
      .title = "What the loops take between read and write",
      .what =
          "Between read and write the bare and the asynchronous loop do little more than copy two "
          "buffers; the synchronous one runs its controllers there, and takes the longer for "
          "it.",
      .svg = report::DrawChart(
          {.columns = 2, .width = 1040, .panel_height = 340, .panels = {density, tail}}),
      .columns =
          "d_EXT [us],LF in bin [%],LF above [1],RS in bin [%],RS above [1],RA in bin "
          "[%],RA above [1]",
      .rows = std::move(rows)};
}

Figure IntervalFigure(const LoopRuns& runs) {
  constexpr double kWidth = 20;  // us
  constexpr std::size_t kBins = 220;
  std::vector<double> edges(kBins + 1);
  for (std::size_t i = 0; i <= kBins; ++i) edges[i] = kWidth * static_cast<double>(i);
  std::vector<std::vector<double>> rows(kBins);
  std::vector<double> centres_ms(kBins);
  for (std::size_t i = 0; i < kBins; ++i) {
    rows[i] = {edges[i] + kWidth / 2};
    centres_ms[i] = 1e-3 * rows[i][0];
  }
  report::Chart chart{.width = 1040, .panel_height = 200};
  for (const std::size_t loop : {kSynchronous, kBare, kAsynchronous}) {
    const std::vector<double> values = Pooled(runs[loop], &LoopSample::interval_us);
    const std::vector<double> shares = Histogram(values, edges);
    for (std::size_t i = 0; i < kBins; ++i) rows[i].push_back(shares[i]);
    chart.panels.push_back(
        IntervalPanel(loop, centres_ms, shares, 1 / static_cast<double>(values.size())));
  }
  chart.panels.back().x_label = "time between two reads [ms]";
  return {
      .id = "intervals",
      .title = "From one read to the next",
      .what =
          "The synchronous loop, when it misses a state, waits for a later one: its "
          "intervals pile up around 2 and 3 cycles (B, C). Those of the other two, paced by the "
          "states, are all around 1 ms (A), but where a state comes late: a long interval, and "
          "a short one after it.",
      .svg = report::DrawChart(chart),
      .columns = "interval [us],RS [1],LF [1],RA [1]",
      .rows = std::move(rows)};
}

}  // namespace twin::experiment
