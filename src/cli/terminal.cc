#include "cli/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

namespace twin::cli {

Progress::Progress(std::string what, bool quiet, const Clock& clock)
    : what_(std::move(what)),
      quiet_(quiet),
      is_terminal_(isatty(STDOUT_FILENO) != 0),
      clock_(clock) {}

void Progress::EndLine() {
  if (std::exchange(drawn_, false)) cli::Say(stdout, "\n");
}

void Progress::Show(double share, std::string_view note) {
  share = std::clamp(share, 0.0, 1.0);
  if (quiet_) return;
  if (is_terminal_) return DrawBar(share, note);
  const int tenths = static_cast<int>(share * 10);
  if (tenths <= tenths_) return;
  tenths_ = tenths;
  cli::Say(stdout, fmt::format("{:<6}{:4d} %  {}\n", what_, 10 * tenths, note));
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
  cli::Say(stdout, fmt::format("\r{:<6}[{:#<{}}{:.<{}}] {:3.0f} %  {}\x1b[K", what_, "", filled, "",
                               kWidth - filled, 100 * share, note));
  std::fflush(stdout);
}

void Terminal::Print(std::string_view text) {
  if (!quiet_) Say(text);
}

void Terminal::Say(std::string_view text) {
  if (progress_) progress_->EndLine();
  cli::Say(stdout, text);
  std::fflush(stdout);
}

void Terminal::Write(spdlog::level::level_enum level, std::string_view text) {
  if (progress_) progress_->EndLine();
  log_->log(level, text);
}

void Terminal::Show(std::string_view work, double share, std::string_view note) {
  if (!progress_ || progress_->what() != work) {
    progress_.reset();  // which ends its line
    progress_.emplace(std::string(work), quiet_, clock_);
  }
  progress_->Show(share, note);
}

}  // namespace twin::cli
