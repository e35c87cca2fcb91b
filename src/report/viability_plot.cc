#include <algorithm>
#include <string>

#include "report/joint_plots.h"
#include "report/script.h"
#include "twin/core/time.h"

namespace twin::report {
namespace {

void AddMarginPanel(Script& script, const RunData& run) {
  const rt::FilterCounts::Nearest least = run.filter.nearest.value_or(rt::FilterCounts::Nearest());
  script.Curve("margin", run.margin, 0);
  script.Line("set title {} offset 0,-0.6",
              Quote(fmt::format(
                  "what the worst losses leave of a joint's range, speed or acceleration, as a "
                  "share of it: at least {:.3g}, at {:.4g} s",
                  least.margin, ToSeconds(least.at.time_since_epoch()))));
  script.Line("set ylabel 'margin'");
  // In the middle of its range a joint has half of it to either end.
  script.Line("set yrange [{:.6g}:0.5]", std::min(-0.05, 1.1 * least.margin));
  script.Line(
      "plot 0 w l dt 2 lw 1.5 lc '{}' title 'border', $margin w l lw 1.2 lc '{}' title 'margin'",
      kLimitColour, kReferenceColour);
}

/// Of each joint when its command was kept back, on a line of its own, joint 1 on top.
void AddActivityPanel(Script& script, const RunData& run) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    script.Curve(fmt::format("joint{}", i + 1), run.kept_back, i);
  }
  script.Line("set title {} offset 0,-0.6",
              Quote(fmt::format("commands kept back: {} of {} ({:.3g} %)", run.filter.kept_back,
                                run.filter.commands, run.filter.kept_back_percent())));
  script.Line("set xlabel 'time / s' offset 0,0.6");
  script.Line("set ylabel 'joint'");
  script.Line("set yrange [7.6:0.4]; set ytics 1");
  std::string plot = "plot ";
  for (std::size_t i = 0; i < kJoints; ++i) {
    plot += fmt::format("{}$joint{} w p pt 5 ps 0.35 lc '{}' {}", i == 0 ? "" : ", ", i + 1,
                        kHeldColour, i == 0 ? "title 'kept back'" : "notitle");
  }
  script.Line("{}", plot);
}

}  // namespace

std::string ViabilityScript(const RunData& run) {
  Script script(1200, 640, Title(run, "viability filter"), 2, 1);
  script.Line("set xrange {}", TimeRange(run));
  script.Line("set lmargin 11; set rmargin 18; set tmargin 3; set bmargin 3");
  // Right of the panel, where it covers nothing.
  script.Line("set key at screen 0.88,graph 0.95 left top Left reverse samplen 2 spacing 1.3");
  MarkMotions(script, run);
  MarkAbort(script, run);
  AddMarginPanel(script, run);
  AddActivityPanel(script, run);
  return script.End();
}

}  // namespace twin::report
