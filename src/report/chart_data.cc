#include "report/chart_data.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace twin::report {
namespace {

constexpr std::size_t kShort = 4000;  ///< points that are all drawn
constexpr double kPlaces = 2000;      ///< of the x axis

/// Which 2000th of the axis a value falls into; beyond the axis -1 or kPlaces.
int PlaceOf(double x, const Axes& axes) {
  const auto on_axis = [&](double value) { return axes.log_x ? std::log(value) : value; };
  const double low = on_axis(axes.x_range[0]);
  const double share = (on_axis(x) - low) / (on_axis(axes.x_range[1]) - low);
  return static_cast<int>(std::floor(std::clamp(share * kPlaces, -1.0, kPlaces)));
}

/// The lowest and the highest of some points, in their order.
void AppendExtremes(const std::vector<Point>& group, std::vector<Point>& points) {
  if (group.empty()) return;
  const auto lower = [](const Point& a, const Point& b) { return a.y < b.y; };
  auto [first, second] = std::minmax_element(group.begin(), group.end(), lower);
  if (second < first) std::swap(first, second);
  points.push_back(*first);
  if (first != second) points.push_back(*second);
}

}  // namespace

bool CanBeDrawn(double value, bool log) noexcept {
  return std::abs(value) < 1e100 && (!log || value > 0);
}

std::vector<double> CellEdges(const std::vector<double>& centres, bool log) {
  if (centres.empty()) return {};
  if (centres.size() == 1) {
    return log ? std::vector{centres[0] / 2, centres[0] * 2}
               : std::vector{centres[0] - 0.5, centres[0] + 0.5};
  }
  std::vector<double> edges(centres.size() + 1);
  const auto middle = [log](double a, double b) { return log ? std::sqrt(a * b) : (a + b) / 2; };
  for (std::size_t i = 1; i < centres.size(); ++i) edges[i] = middle(centres[i - 1], centres[i]);
  const auto beyond = [log](double centre, double inner) {
    return log ? centre * centre / inner : 2 * centre - inner;
  };
  edges.front() = beyond(centres.front(), edges[1]);
  edges.back() = beyond(centres.back(), edges[centres.size() - 1]);
  return edges;
}

std::vector<Point> PointsToDraw(const ChartCurve& curve, const Axes& axes) {
  std::vector<Point> points;
  std::vector<Point> group;  // points in a row in the same place
  int place = 0;
  const auto flush = [&] {
    AppendExtremes(group, points);
    group.clear();
  };
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!CanBeDrawn(curve.x[i], axes.log_x) || !CanBeDrawn(curve.y[i], axes.log_y)) {
      flush();
      if (!points.empty() && !points.back().is_gap) points.push_back({0, 0, true});
      continue;
    }
    const int here = PlaceOf(curve.x[i], axes);
    if (curve.x.size() <= kShort || here != place) flush();
    place = here;
    group.push_back({curve.x[i], curve.y[i]});
  }
  flush();
  return points;
}

}  // namespace twin::report
