#pragma once

#include <array>
#include <vector>

#include "twin/report/chart.h"

namespace twin::report {

/// What of a panel's axes decides on how its curves are drawn.
struct Axes {
  bool log_x = false;
  bool log_y = false;
  std::array<double, 2> x_range{};
};

/// A point that is drawn, or a gap in a line.
struct Point {
  double x = 0;
  double y = 0;
  bool is_gap = false;
};

/// Whether gnuplot can take it as a number of a curve, on such an axis.
[[nodiscard]] bool CanBeDrawn(double value, bool log) noexcept;

/// Borders of the cells around `centres`: midway between neighbours (on a logarithmic axis the
/// geometric mean), as far beyond the outermost ones. One more than there are centres; of a single
/// centre 0.5 to either side (a factor of 2). Empty for none.
[[nodiscard]] std::vector<double> CellEdges(const std::vector<double>& centres, bool log);

/// The curve's points in their order; of a long curve, of those in a row that fall into the same
/// 2000th of the x axis, only the lowest and the highest. Gaps where a value cannot be drawn.
[[nodiscard]] std::vector<Point> PointsToDraw(const ChartCurve& curve, const Axes& axes);

}  // namespace twin::report
