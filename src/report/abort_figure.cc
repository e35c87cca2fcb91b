#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "report/abort_panels.h"

namespace twin::report {
namespace {

constexpr double kUndrawn = std::numeric_limits<double>::quiet_NaN();

/// Index relative to the last cycle: 0 for the last, negative before.
double Offset(const RunEnd& end, std::size_t index) {
  return static_cast<double>(index) - static_cast<double>(end.cycles.size()) + 1;
}

/// Lowest and highest value of a panel, with a margin; never an empty range.
std::pair<double, double> RangeOf(const EndPanel& panel) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto include = [&](double value) {
    if (!(std::abs(value) < 1e100)) return;  // gnuplot cannot draw it
    low = std::min(low, value);
    high = std::max(high, value);
  };
  for (const EndCurve& curve : panel.curves) std::ranges::for_each(curve.values, include);
  if (panel.limits_in_view) std::ranges::for_each(panel.limits, include);
  if (panel.offender) include(*panel.offender);
  if (low > high) return {-1, 1};
  const double least = std::max({std::abs(low), std::abs(high), 1e-9}) * 1e-6;
  const double room = std::max(0.08 * (high - low), least);
  return {low - room, high + room};
}

/// Adds a row for each cycle with the fate of its command, and dropped commands.
void AddCycles(const RunEnd& end, Figure& figure) {
  figure.columns = "cycle,served,held,none,dropped";
  int held = 0;
  for (std::size_t i = 0; i < end.cycles.size(); ++i) {
    const record::CycleRecord& cycle = end.cycles[i].cycle;
    const auto is = [&](record::CommandFate fate) { return cycle.fate == fate ? 1.0 : 0.0; };
    figure.rows.push_back({Offset(end, i), is(record::CommandFate::kServed),
                           is(record::CommandFate::kHeld), is(record::CommandFate::kNone),
                           static_cast<double>(cycle.dropped)});
    if (cycle.fate != record::CommandFate::kHeld) continue;
    figure.values[fmt::format("held_{}", ++held)] = Offset(end, i);
  }
  figure.values["begin"] = Offset(end, 0);
  figure.values["held"] = held;
}

}  // namespace

Figure EndFigure(const RunEnd& end, const std::vector<EndPanel>& panels) {
  Figure figure{.id = "end"};
  AddCycles(end, figure);
  std::vector<std::string> curves;
  int first = 1;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const EndPanel& panel = panels[i];
    const auto set = [&](std::string_view key, double value) {
      figure.values[fmt::format(fmt::runtime(key), i + 1)] = value;
    };
    const auto [low, high] = RangeOf(panel);
    set("low_{}", low);
    set("high_{}", high);
    std::array<double, 2> limits{kUndrawn, kUndrawn};
    std::ranges::copy_if(panel.limits, limits.begin(),
                         [low = low, high = high](double x) { return x >= low && x <= high; });
    set("limit_{}_1", limits[0]);
    set("limit_{}_2", limits[1]);
    set("offender_{}", panel.offender.value_or(kUndrawn));
    set("first_{}", first);
    for (const EndCurve& curve : panel.curves) {
      figure.values[fmt::format("points_{}", first)] = curve.points ? 1 : 0;
      figure.columns += fmt::format(",{}", first++);
      for (std::size_t k = 0; k < figure.rows.size(); ++k) {
        figure.rows[k].push_back(curve.values[k]);
      }
      curves.insert(curves.end(), {curve.name, std::string(curve.colour)});
    }
    set("last_{}", first - 1);
    figure.names.insert(figure.names.end(), {panel.title, panel.unit});
  }
  figure.names.insert(figure.names.end(), curves.begin(), curves.end());
  figure.names.emplace_back(end.fates_unknown() ? "not known" : "none due");
  figure.values["panels"] = static_cast<double>(panels.size());
  return figure;
}

}  // namespace twin::report
