#include <algorithm>
#include <string>

#include "report/joint_plots.h"
#include "report/script.h"

namespace twin::report {
namespace {

/// "12 (0.5 %)".
std::string Share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return std::to_string(part);
  return fmt::format("{} ({:.4g} %)", part,
                     100.0 * static_cast<double>(part) / static_cast<double>(whole));
}

/// Adds `$fates`: time, shares of the cycles stacked (served; with held; with none), held, dropped.
void AddFates(Script& script, const RunData& run) {
  script.Line("$fates << EOD");
  const auto add = [&script](double time, const FateCounts& span) {
    const double percent = 100.0 / static_cast<double>(span.cycles());
    const auto served = static_cast<double>(span.served);
    const auto held = static_cast<double>(span.held);
    script.Line("{:.7g} {:.6g} {:.6g} 100 {} {}", time, percent * served, percent * (served + held),
                span.held, span.dropped);
  };
  const auto& spans = run.fates.spans();
  for (const FateCounts& span : spans) add(span.begin, span);
  // The steps are drawn up to the next time: the last span needs one.
  add(run.end + 1e-3, spans.back());
  script.Line("EOD");
}

void AddFatePanels(Script& script, const RunData& run) {
  const FateCounts& total = run.total;
  const std::uint64_t motion = total.served + total.held;
  script.Line(
      "set title {} offset 0,-0.6",
      Quote(fmt::format(
          "{} cycles of motion: {} served, {} held, at most {} in a row; {} without motion", motion,
          Share(total.served, motion), Share(total.held, motion), run.longest_loss, total.none)));
  script.Line("set ylabel 'share / %'");
  script.Line("set yrange [0:100]");
  std::string plot = fmt::format(
      "plot $fates u 1:4 w fillsteps fc '{}' title 'no motion', "
      "$fates u 1:3 w fillsteps fc '{}' title 'held', "
      "$fates u 1:2 w fillsteps fc '{}' title 'served'",
      kQuietColour, kHeldColour, kServedColour);
  if (run.abort) plot += fmt::format(", NaN w l lw 2 lc '{}' title 'abort'", kAbortColour);
  script.Line("{}", plot);

  std::uint64_t most = 1;
  for (const FateCounts& span : run.fates.spans()) most = std::max({most, span.held, span.dropped});
  script.Line(
      "set title {} offset 0,-0.6",
      Quote(fmt::format("per {} cycles: cycles held, {} in all; commands dropped, {} in all",
                        run.fates.cycles_per_span(), total.held, total.dropped)));
  script.Line("set ylabel 'count'");
  script.Line("set yrange [0:{:.6g}]", 1.15 * static_cast<double>(most));
  script.Line(
      "plot $fates u 1:5 w impulses lw 2.5 lc '{}' title 'held cycles', "
      "$fates u 1:($6 > 0 ? $6 : NaN) w p pt 7 ps 0.5 lc '{}' title 'dropped commands'",
      kHeldColour, kReferenceColour);
}

void AddTimingPanels(Script& script, const RunData& run) {
  const auto delays = run.d_EXT.Curve(0);
  double longest = 0;
  for (const Sample& sample : delays) longest = std::max(longest, sample.value);
  script.Curve("delay", run.d_EXT, 0);
  script.Line(
      "set title {} offset 0,-0.6",
      Quote(delays.empty() ? std::string("d_EXT, read to write: no command was written")
                           : fmt::format("d_EXT, read to write: at most {:.4g} µs", longest)));
  script.Line("set ylabel 'd_EXT / µs'");
  script.Line("set yrange [0:{:.6g}]", longest > 0 ? 1.2 * longest : 1.0);
  script.Line("plot $delay w l lw 1.2 lc '{}' notitle", kReferenceColour);

  const auto rates = run.success_rate.Curve(0);
  double lowest = 1;
  for (const Sample& sample : rates) lowest = std::min(lowest, sample.value);
  script.Curve("rate", run.success_rate, 0);
  script.Line(
      "set title {} offset 0,-0.6",
      Quote("control_command_success_rate: share of the last 100 commands received, while a "
            "motion runs"));
  script.Line("set xlabel 'time / s' offset 0,0.6");
  script.Line("set ylabel 'success rate'");
  // A loss of one command in a hundred must be seen; so the axis begins near the lowest rate.
  script.Line("set yrange [{:.6g}:{:.6g}]", std::max(0.0, std::min(0.9, lowest - 0.05)), 1.02);
  script.Line("plot $rate w l lw 1.5 lc '{}' notitle", kReferenceColour);
}

}  // namespace

std::string ServedScript(const RunData& run) {
  Script script(1200, 1000, Title(run, "commands served"), 4, 1);
  script.Line("set xrange {}", TimeRange(run));
  script.Line("set lmargin 11; set rmargin 22; set tmargin 3; set bmargin 3");
  // Right of the panel, where it covers nothing.
  script.Line("set key at screen 0.86,graph 0.95 left top Left reverse samplen 2 spacing 1.3");
  script.Line("set style fill solid noborder");
  MarkMotions(script, run);
  MarkAbort(script, run);
  AddFates(script, run);
  AddFatePanels(script, run);
  AddTimingPanels(script, run);
  return script.End();
}

}  // namespace twin::report
