#include "report/abort_figure.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/abort_panels.h"
#include "report/script.h"

namespace twin::report {
namespace {

constexpr int kWidth = 1040;
constexpr int kPanelHeight = 170;
constexpr std::string_view kHeldShade = "#fbe3e5";

/// Index relative to the last cycle: 0 for the last, negative before.
int Offset(const RunEnd& end, std::size_t index) {
  return static_cast<int>(index) - static_cast<int>(end.cycles.size()) + 1;
}

/// True if gnuplot accepts the number in a curve.
bool CanBeDrawn(double value) {
  return std::abs(value) < 1e100;
}

/// Lowest and highest value of a panel, with a margin; never an empty range.
std::pair<double, double> RangeOf(const EndPanel& panel) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto include = [&](double value) {
    if (!CanBeDrawn(value)) return;
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

void AddData(Script& script, const RunEnd& end, std::string_view name,
             const std::vector<double>& values) {
  script.Line("${} << EOD", name);
  bool any = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    // An empty line interrupts the curve; a missing point would not.
    if (!CanBeDrawn(values[i])) {
      script.Line("");
      continue;
    }
    any = true;
    script.Line("{} {:.9g}", Offset(end, i), values[i]);
  }
  if (!any) script.Line("0 NaN");
  script.Line("EOD");
}

void AddPanel(Script& script, const RunEnd& end, const EndPanel& panel) {
  const auto [low, high] = RangeOf(panel);
  std::string plot = "plot ";
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const EndCurve& curve = panel.curves[i];
    AddData(script, end, fmt::format("curve{}", i), curve.values);
    plot += fmt::format("$curve{} w {} lc '{}' title {}, ", i,
                        curve.points ? "p pt 6 ps 0.6 lw 1.2" : "lp pt 7 ps 0.25 lw 1.6",
                        curve.colour, Quote(curve.name));
  }
  bool named = false;
  for (const double limit : panel.limits) {
    if (limit < low || limit > high) continue;
    plot += fmt::format("{:.9g} w l dt 2 lw 1.5 lc '{}' {}, ", limit, kLimitColour,
                        named ? "notitle" : "title 'limit'");
    named = true;
  }
  if (panel.offender && CanBeDrawn(*panel.offender)) {
    script.Line("$offender << EOD\n0 {:.9g}\nEOD", *panel.offender);
    plot += fmt::format("$offender w p pt 7 ps 1 lc '{}' title {}, ", kAbortColour,
                        Quote(fmt::format("raised it: {:.6g}", *panel.offender)));
  }
  plot.resize(plot.size() - 2);
  script.Line("set title {} offset 0,-0.6", Quote(panel.title));
  script.Line("set ylabel {} offset 0.5,0", Quote(panel.unit));
  script.Line("set yrange [{:.9g}:{:.9g}]", low, high);
  script.Line("{}", plot);
}

/// Adds the fate of each cycle's command (served, held, none due or unknown) and dropped commands.
void AddFates(Script& script, const RunEnd& end) {
  script.Line("$fates << EOD");
  for (std::size_t i = 0; i < end.cycles.size(); ++i) {
    const record::CycleRecord& cycle = end.cycles[i].cycle;
    script.Line("{} {} {} {} {}", Offset(end, i),
                cycle.fate == record::CommandFate::kServed ? 1 : 0,
                cycle.fate == record::CommandFate::kHeld ? 1 : 0,
                cycle.fate == record::CommandFate::kNone ? 1 : 0, cycle.dropped);
  }
  script.Line("EOD");
  script.Line("set title 'what became of each command' offset 0,-0.6");
  script.Line("set format x '%g'; set bmargin 3");
  script.Line("set key spacing 0.9");  // four entries in one column
  script.Line("set xlabel 'cycles of 1 ms, 0: the one that raised the error' offset 0,0.6");
  script.Line("unset ylabel; set yrange [0:1.25]; set ytics ('' 0)");
  script.Line("set style fill solid border lc '#ffffff'");
  script.Line("set boxwidth 1");
  script.Line(
      "plot $fates u 1:2 w boxes fc '{}' title 'served', $fates u 1:3 w boxes fc '{}' title "
      "'held', "
      "$fates u 1:4 w boxes fc '{}' title '{}', "
      "$fates u 1:($5 > 0 ? 1.12 : NaN) w p pt 11 ps 0.9 lc '{}' title 'dropped'",
      kServedColour, kHeldColour, kQuietColour, end.fates_unknown() ? "not known" : "none due",
      kReferenceColour);
}

}  // namespace

std::string EndScript(const RunEnd& end) {
  const std::vector<EndPanel> panels = EndPanels(end);
  const int rows = static_cast<int>(panels.size()) + 1;
  Script script(kWidth, kPanelHeight * rows, "", rows, 1);
  script.Line("set xrange [{}:0.7]", Offset(end, 0) - 0.7);
  script.Line("set lmargin 13; set rmargin 26; set tmargin 2; set bmargin 1.5");
  // To the right of the panel, where it hides nothing.
  script.Line("set key at screen 0.805,graph 0.98 left top Left reverse samplen 2 spacing 1.2");
  script.Line("set format y '%.6g'; set format x ''");
  for (std::size_t i = 0; i < end.cycles.size(); ++i) {
    if (end.cycles[i].cycle.fate != record::CommandFate::kHeld) continue;
    const int x = Offset(end, i);
    script.Line(
        "set object rectangle from first {},graph 0 to first {},graph 1 fc rgb '{}' fs solid "
        "noborder behind",
        x - 0.5, x + 0.5, kHeldShade);
  }
  script.Line("set arrow from first 0,graph 0 to first 0,graph 1 nohead back lw 1 dt 3 lc '{}'",
              kAbortColour);
  for (const EndPanel& panel : panels) AddPanel(script, end, panel);
  AddFates(script, end);
  return script.End();
}

}  // namespace twin::report
