#include "twin/report/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "report/chart_data.h"
#include "report/gnuplot.h"
#include "report/script.h"
#include "twin/core/check.h"

namespace twin::report {
namespace {

using Range = std::array<double, 2>;

/// Lowest and highest of what an axis has to show.
class Extent {
 public:
  explicit Extent(bool log) : log_(log) {}

  void Include(double value) {
    if (!CanBeDrawn(value, log_)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }

  /// @param room  on either side: share of the range. @returns a range that is never empty.
  [[nodiscard]] Range With(double room) const {
    if (low_ > high_) return log_ ? Range{1, 10} : Range{0, 1};
    if (log_) {
      const double factor = low_ < high_ ? std::pow(high_ / low_, room) : 2;
      return {low_ / factor, high_ * factor};
    }
    const double least = std::max({std::abs(low_), std::abs(high_), 1e-9}) * 1e-6;
    const double margin = low_ < high_ ? std::max(room * (high_ - low_), least)
                                       : std::max(0.1 * std::abs(low_), least);
    // An axis of what cannot be negative begins at 0.
    return {low_ == 0 ? 0 : low_ - margin, high_ + margin};
  }

 private:
  bool log_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

Range XRange(const ChartPanel& panel) {
  if (panel.x_range) return *panel.x_range;
  Extent extent(panel.log_x);
  bool is_flush = true;
  const auto include_edges = [&](const std::vector<double>& centres) {
    for (const double edge : CellEdges(centres, panel.log_x)) extent.Include(edge);
  };
  for (const ChartCurve& curve : panel.curves) {
    is_flush = is_flush && curve.style != ChartCurve::Style::kPoints;
    if (curve.style == ChartCurve::Style::kBars) include_edges(curve.x);
    for (const double x : curve.x) extent.Include(x);
  }
  if (panel.map) include_edges(panel.map->x);
  return extent.With(is_flush || panel.map ? 0 : 0.04);
}

Range YRange(const ChartPanel& panel, const Range& x_range) {
  if (panel.y_range) return *panel.y_range;
  Extent extent(panel.log_y);
  for (const ChartCurve& curve : panel.curves) {
    if (curve.style == ChartCurve::Style::kBars && !panel.log_y) extent.Include(0);
    for (std::size_t i = 0; i < curve.y.size(); ++i) {
      if (curve.x[i] >= x_range[0] && curve.x[i] <= x_range[1]) extent.Include(curve.y[i]);
    }
  }
  if (!panel.map) return extent.With(0.06);
  for (const double edge : CellEdges(panel.map->y, panel.log_y)) extent.Include(edge);
  return extent.With(0);
}

void SetAxis(Script& script, char axis, const std::string& label, bool log, const Range& range) {
  script.Line("set {}label {}", axis, Quote(label));
  script.Line("{} logscale {}", log ? "set" : "unset", axis);
  script.Line("set {}range [{:.9g}:{:.9g}]", axis, range[0], range[1]);
}

/// @returns the plot's clause.
std::string AddMap(Script& script, const ChartPanel& panel) {
  const HeatMap& map = *panel.map;
  TWIN_CHECK(map.z.size() == map.x.size() * map.y.size());
  const std::vector<double> x = CellEdges(map.x, panel.log_x);
  const std::vector<double> y = CellEdges(map.y, panel.log_y);
  Extent colours(false);
  script.Line("$map << EOD");
  script.Line("NaN NaN NaN NaN NaN NaN NaN");
  for (std::size_t row = 0; row < map.y.size(); ++row) {
    for (std::size_t column = 0; column < map.x.size(); ++column) {
      const double z = map.z[row * map.x.size() + column];
      colours.Include(z);
      if (!CanBeDrawn(z, false)) continue;
      script.Line("{:.7g} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g}", map.x[column], map.y[row],
                  x[column], x[column + 1], y[row], y[row + 1], z);
    }
  }
  script.Line("EOD");
  const Range range = map.z_range ? Range(*map.z_range) : colours.With(0);
  script.Line("set cblabel {}; set cbrange [{:.7g}:{:.7g}]", Quote(map.z_label), range[0],
              range[1]);
  return "$map u 1:2:3:4:5:6:7 w boxxyerror fs solid 1 noborder fc palette notitle, ";
}

std::string_view StyleOf(ChartCurve::Style style) {
  switch (style) {
    case ChartCurve::Style::kLine: return "w l lw 1.6";
    case ChartCurve::Style::kDashed: return "w l dt 2 lw 1.6";
    case ChartCurve::Style::kSteps: return "w steps lw 1.6";
    case ChartCurve::Style::kPoints: return "w p pt 7 ps 0.45";
    case ChartCurve::Style::kBars: break;
  }
  return "u 1:2:3:4:5:2 w boxxyerror fs transparent solid 0.6 noborder";
}

/// @returns the plot's clause.
std::string AddCurve(Script& script, const ChartPanel& panel, std::size_t index,
                     const Range& x_range, const Range& y_range) {
  const ChartCurve& curve = panel.curves[index];
  TWIN_CHECK(curve.x.size() == curve.y.size());
  const bool is_bars = curve.style == ChartCurve::Style::kBars;
  const std::vector<double> edges =
      is_bars ? CellEdges(curve.x, panel.log_x) : std::vector<double>();
  const double foot = panel.log_y ? y_range[0] : 0;
  script.Line("$curve{} << EOD", index);
  script.Line("{}", is_bars ? "NaN NaN NaN NaN NaN" : "NaN NaN\n");
  if (is_bars) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!CanBeDrawn(curve.y[i], panel.log_y)) continue;
      script.Line("{:.9g} {:.7g} {:.9g} {:.9g} {:.7g}", curve.x[i], curve.y[i], edges[i],
                  edges[i + 1], foot);
    }
  } else {
    const Axes axes{panel.log_x, panel.log_y, x_range};
    for (const Point& point : PointsToDraw(curve, axes)) {
      // A gap in the data ends a line, a missing point does not.
      if (point.is_gap) {
        script.Line("");
      } else {
        script.Line("{:.9g} {:.7g}", point.x, point.y);
      }
    }
  }
  script.Line("EOD");
  return fmt::format("$curve{} {} {} '{}' {}, ", index, StyleOf(curve.style), is_bars ? "fc" : "lc",
                     curve.colour,
                     curve.name.empty() ? "notitle" : fmt::format("title {}", Quote(curve.name)));
}

void AddPanel(Script& script, const ChartPanel& panel) {
  const Range x_range = XRange(panel);
  const Range y_range = YRange(panel, x_range);
  SetAxis(script, 'x', panel.x_label, panel.log_x, x_range);
  SetAxis(script, 'y', panel.y_label, panel.log_y, y_range);
  script.Line("set title {} offset 0,-0.5", Quote(panel.title));
  script.Line("set rmargin {}", panel.map ? 15 : 3);
  std::string plot = "plot ";
  if (panel.map) plot += AddMap(script, panel);
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    plot += AddCurve(script, panel, i, x_range, y_range);
  }
  if (plot == "plot ") plot += "NaN notitle, ";
  plot.resize(plot.size() - 2);
  script.Line("{}", plot);
}

}  // namespace

std::string DrawChart(const Chart& chart) {
  TWIN_CHECK(!chart.panels.empty() && chart.columns > 0);
  constexpr int kTitleHeight = 30;
  const int count = static_cast<int>(chart.panels.size());
  const int rows = (count + chart.columns - 1) / chart.columns;
  Script script(chart.width, rows * chart.panel_height + (chart.title.empty() ? 0 : kTitleHeight),
                chart.title, rows, chart.columns);
  script.Line("set lmargin 11; set xlabel offset 0,0.3; set ylabel offset 0.5,0");
  script.Line("set format x '%g'; set format y '%g'");
  // Above the curves, where it covers nothing.
  script.Line("set key tmargin center horizontal Left reverse samplen 2");
  script.Line("set palette defined (0 '#f4f7fb', 0.4 '#7fb0d8', 0.75 '#1f5b9e', 1 '#08244a')");
  for (const ChartPanel& panel : chart.panels) AddPanel(script, panel);
  return SvgOf(script.End());
}

}  // namespace twin::report
