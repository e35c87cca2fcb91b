#include "experiment/client_study_figures.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "experiment/loop_sample.h"
#include "twin/core/time.h"
#include "twin/report/chart.h"

namespace twin::experiment {
namespace {

using report::ChartCurve;
using report::ChartPanel;

}  // namespace

Figure DrawClientLatency(const std::vector<double>& latencies_us) {
  const std::vector<double> edges = LogEdges(4, 4000, 40);
  std::vector<double> shares = Histogram(latencies_us, edges);
  shares.push_back(0);
  const std::vector<double> longer = Exceedance(latencies_us, edges);
  Figure figure{
      .id = "wire",
      .title = "From a state to its answer, on the wire",
      .what =
          "Left how often, right how often longer: what takes a millisecond, less what the "
          "robot needs before its cycle, comes too late.",
      .columns = "d_EXT on the wire [us],in bin [%],longer [1]"};
  ChartCurve density{.colour = report::colour::kBare, .style = ChartCurve::Style::kSteps};
  ChartCurve tail{.colour = report::colour::kBare};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    figure.rows.push_back({edges[i], 100 * shares[i], longer[i]});
    density.x.push_back(edges[i]);
    density.y.push_back(100 * shares[i]);
    tail.x.push_back(edges[i]);
    tail.y.push_back(longer[i]);
  }
  ChartPanel left{.title = "how often",
                  .x_label = "d_EXT on the wire [us]",
                  .y_label = "share of commands in a bin [%]",
                  .log_x = true};
  ChartPanel right{.title = "how often longer",
                   .x_label = "d_EXT on the wire [us]",
                   .y_label = "share of commands that took longer",
                   .log_x = true,
                   .log_y = true};
  left.curves = {std::move(density)};
  right.curves = {std::move(tail)};
  figure.svg = report::DrawChart(
      {.columns = 2, .width = 1040, .panel_height = 340, .panels = {left, right}});
  return figure;
}

Figure DrawClientLosses(const MotionTally& tally) {
  constexpr std::size_t kMostPoints = 4000;
  Figure figure{.id = "losses",
                .title = "Unserved cycles in a row",
                .what =
                    "Each spike is a burst of lost commands; one that reaches the line ends the "
                    "motion. Motions follow each other without the time between them.",
                .columns = "t [s],unserved in a row [1]"};
  const std::vector<std::uint8_t>& lost = tally.lost_in_row();
  const std::size_t step = lost.size() / kMostPoints + 1;
  ChartCurve curve{.name = "unserved in a row",
                   .colour = report::colour::kSynchronous,
                   .style = ChartCurve::Style::kSteps};
  for (std::size_t k = 0; k < lost.size(); k += step) {
    const auto end = lost.begin() + static_cast<std::ptrdiff_t>(std::min(k + step, lost.size()));
    const double most = *std::max_element(lost.begin() + static_cast<std::ptrdiff_t>(k), end);
    const double t = static_cast<double>(k) * kCycleSeconds;
    figure.rows.push_back({t, most});
    curve.x.push_back(t);
    curve.y.push_back(most);
  }
  const auto ends = static_cast<double>(MotionTally::EndsTheMotion());
  const double last = curve.x.empty() ? 1 : curve.x.back();
  ChartCurve limit{.name = "ends the motion",
                   .colour = report::colour::kLimit,
                   .style = ChartCurve::Style::kDashed,
                   .x = {0, last},
                   .y = {ends, ends}};
  ChartPanel panel{.x_label = "time in motion [s]", .y_label = "cycles"};
  panel.curves = {std::move(curve), std::move(limit)};
  figure.svg = report::DrawChart({.width = 1040, .panel_height = 240, .panels = {panel}});
  return figure;
}

}  // namespace twin::experiment
