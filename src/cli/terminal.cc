#include "cli/terminal.h"

#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "cli/say.h"

namespace twin::cli {

void Terminal::Print(std::string_view text) {
  if (!quiet_) Say(text);
}

void Terminal::Say(std::string_view text) {
  if (progress_) progress_->EndLine();
  cli::Say(stdout, text);
  std::fflush(stdout);
}

void Terminal::Note(std::string_view text) {
  if (progress_) progress_->EndLine();
  cli::Say(stderr, fmt::format("panda-twin: note: {}\n", text));
}

void Terminal::Warn(std::string_view text) {
  if (progress_) progress_->EndLine();
  std::fflush(stdout);
  cli::Say(stderr, fmt::format("panda-twin: warning: {}\n", text));
}

void Terminal::Show(std::string_view work, double share, std::string_view note) {
  if (!progress_ || progress_->what() != work) {
    progress_.reset();  // which ends its line
    progress_.emplace(std::string(work), Progress::StyleOfStdout(quiet_), clock_);
  }
  progress_->Show(share, note);
}

}  // namespace twin::cli
