#include "cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "cli/say.h"

namespace twin::cli {

Progress::Style Progress::StyleOfStdout(bool quiet) {
  if (quiet) return Style::kNone;
  return isatty(STDOUT_FILENO) != 0 ? Style::kBar : Style::kLines;
}

Progress::Progress(std::string what, Style style, const Clock& clock)
    : what_(std::move(what)), style_(style), clock_(clock) {}

Progress::~Progress() {
  EndLine();
}

void Progress::EndLine() {
  if (std::exchange(drawn_, false)) Say(stdout, "\n");
}

void Progress::Show(double share, std::string_view note) {
  share = std::clamp(share, 0.0, 1.0);
  if (style_ == Style::kBar) DrawBar(share, note);
  if (style_ != Style::kLines) return;
  const int tenths = static_cast<int>(share * 10);
  if (tenths <= tenths_) return;
  tenths_ = tenths;
  Say(stdout, fmt::format("{:<6}{:4d} %  {}\n", what_, 10 * tenths, note));
  std::fflush(stdout);
}

void Progress::DrawBar(double share, std::string_view note) {
  constexpr int kWidth = 30;
  constexpr Duration kRedraw = std::chrono::milliseconds(100);
  const Time now = clock_.Now();
  const bool completes = share >= 1 && !complete_;
  if (drawn_ && now < next_draw_ && !completes) return;
  next_draw_ = now + kRedraw;
  drawn_ = true;
  complete_ = share >= 1;
  const int filled = static_cast<int>(share * kWidth);
  // \r and "erase to the end of the line" redraw it in place.
  Say(stdout, fmt::format("\r{:<6}[{:#<{}}{:.<{}}] {:3.0f} %  {}\x1b[K", what_, "", filled, "",
                          kWidth - filled, 100 * share, note));
  std::fflush(stdout);
}

}  // namespace twin::cli
