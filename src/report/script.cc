#include "report/script.h"

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

}  // namespace twin::report
