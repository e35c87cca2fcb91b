#include "cli/terminal.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

namespace twin::cli {

Terminal::Terminal(Log log, bool quiet)
    : log_(std::move(log)), quiet_(quiet), is_terminal_(isatty(STDOUT_FILENO) != 0) {}

void Terminal::Print(std::string_view text) {
  if (!quiet_) Say(text);
}

void Terminal::Say(std::string_view text) {
  EndLine();
  cli::Say(stdout, text);
  std::fflush(stdout);
}

void Terminal::Write(spdlog::level::level_enum level, std::string_view text) {
  EndLine();
  log_->log(level, text);
}

void Terminal::EndLine() {
  if (std::exchange(drawn_, false)) cli::Say(stdout, "\n");
}

void Terminal::Show(std::string_view work, double share, std::string_view note) {
  share = std::clamp(share, 0.0, 1.0);
  if (quiet_) return;
  if (progress_.work != work) {
    EndLine();
    progress_ = {.work = std::string(work)};
  }
  if (is_terminal_) return DrawBar(share, note);
  const int tenths = static_cast<int>(share * 10);
  if (tenths <= progress_.tenths) return;
  progress_.tenths = tenths;
  cli::Say(stdout, fmt::format("{:<6}{:4d} %  {}\n", work, 10 * tenths, note));
  std::fflush(stdout);
}

void Terminal::DrawBar(double share, std::string_view note) {
  constexpr int kWidth = 30;
  constexpr Duration kRedraw = std::chrono::milliseconds(100);
  const Time now = clock_.Now();
  const bool completes = share >= 1 && !progress_.complete;
  if (drawn_ && now < progress_.next_draw && !completes) return;
  progress_.next_draw = now + kRedraw;
  progress_.complete = share >= 1;
  drawn_ = true;
  const int filled = static_cast<int>(share * kWidth);
  // \r and "erase to the end of the line" redraw it in place.
  cli::Say(stdout, fmt::format("\r{:<6}[{:#<{}}{:.<{}}] {:3.0f} %  {}\x1b[K", progress_.work, "",
                               filled, "", kWidth - filled, 100 * share, note));
  std::fflush(stdout);
}

bool Terminal::CanAsk() noexcept {
  return isatty(STDIN_FILENO) != 0;
}

void Terminal::AwaitEnter() const {
  constexpr int kLookMs = 50;
  while (true) {
    ThrowIfInterrupted();
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (::poll(&input, 1, kLookMs) <= 0) continue;
    char typed = 0;
    if (::read(STDIN_FILENO, &typed, 1) <= 0) throw run::Interrupted();
    if (typed == '\n') return;
  }
}

void Terminal::ConfirmMotion(std::string_view what) {
  constexpr int kCountdown = 3;
  ::tcflush(STDIN_FILENO, TCIFLUSH);  // what was typed before the question does not answer it
  Say(fmt::format("{}\npress Enter to move; Ctrl-C ends the run\n", what));
  AwaitEnter();
  for (int left = kCountdown; left > 0; --left) {
    Say(fmt::format("the arm moves in {} s; Ctrl-C ends the run\n", left));
    const Time next = clock_.Now() + std::chrono::seconds(1);
    while (clock_.Now() < next) {
      ThrowIfInterrupted();
      static_cast<void>(::poll(nullptr, 0, 20));
    }
  }
  ThrowIfInterrupted();
}

}  // namespace twin::cli
