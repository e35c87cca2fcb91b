#include "report/script.h"

#include <algorithm>

namespace twin::report {

Script::Script(int width, int height, std::string_view title, int rows, int columns) {
  Line("set encoding utf8");
  Line("set terminal svg size {},{} noenhanced font 'DejaVu Sans,12' background '#ffffff'", width,
       height);
  Line("set multiplot layout {},{} title {} font ',16' noenhanced", rows, columns, Quote(title));
  Line("set border 3 lc '#555555'");
  Line("set tics nomirror out scale 0.5");
  Line("set grid lc '#dddddd' lt 1 lw 0.5");
}

void Script::Curve(std::string_view name, const Envelope& envelope, std::size_t curve) {
  Line("${} << EOD", name);
  const auto samples = envelope.Curve(curve);
  if (samples.empty()) Line("0 NaN");
  for (const Sample& sample : samples) Line("{:.7g} {:.6g}", sample.time, sample.value);
  Line("EOD");
}

std::string Script::End() {
  Line("unset multiplot");
  return std::move(text_);
}

std::string Quote(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
  }
  return quoted + "'";
}

std::string Title(const RunData& run, std::string_view what) {
  return fmt::format(
      "{}: {}{}{}", run.scenario, what,
      run.abort ? fmt::format(", aborted at {:.4g} s: {}", run.abort->time, run.abort->name) : "",
      run.truncated ? " (the run was killed: its end is missing)" : "");
}

void MarkAbort(Script& script, const RunData& run) {
  if (!run.abort) return;
  script.Line(
      "set arrow from first {0:.7g},graph 0 to first {0:.7g},graph 1 nohead front lw 2 lc '{1}'",
      run.abort->time, kAbortColour);
}

void MarkMotions(Script& script, const RunData& run) {
  if (run.motions.size() < 2) return;
  for (std::size_t i = 0; i < run.motions.size(); ++i) {
    script.Line(
        "set arrow from first {0:.7g},graph 0 to first {0:.7g},graph 1 nohead back lw 0.8 dt 3 "
        "lc '#888888'",
        run.motions[i]);
    script.Line(
        "set label '{}' at first {:.7g},graph 0.97 left offset 0.2,0 front font ',8' "
        "textcolor '#888888'",
        i + 1, run.motions[i]);
  }
}

std::string TimeRange(const RunData& run) {
  return fmt::format("[{:.7g}:{:.7g}]", run.begin, std::max(run.end, run.begin + 1e-3));
}

}  // namespace twin::report
