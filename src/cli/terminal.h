#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cli/interrupt.h"
#include "cli/log.h"
#include "twin/core/clock.h"
#include "twin/run/console.h"

namespace twin::cli {

/// Shows how far a piece of work is: a bar that is redrawn on a terminal, a line about every tenth
/// otherwise.
///
/// Threads: one thread.
class Progress {
 public:
  /// @param what   "run", "video". @param quiet  shows nothing. @param clock  must outlive this.
  Progress(std::string what, bool quiet, const Clock& clock);
  /// Ends the bar's line.
  ~Progress() { EndLine(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param share  done, in [0, 1]; more counts as all. @param note  shown behind it.
  void Show(double share, std::string_view note);
  /// Before something else is printed.
  void EndLine();
  [[nodiscard]] const std::string& what() const noexcept { return what_; }

 private:
  void DrawBar(double share, std::string_view note);

  const std::string what_;
  const bool quiet_;
  const bool is_terminal_;
  const Clock& clock_;
  int tenths_ = 0;  ///< lines printed so far
  bool drawn_ = false;
  bool complete_ = false;
  Time next_draw_{};
};

/// The terminal of a run: results on standard output, messages in the log, and interrupts.
class Terminal final : public run::Console {
 public:
  /// @param quiet  neither Print() nor Show() do anything.
  Terminal(Log log, bool quiet) : log_(std::move(log)), quiet_(quiet) {}

  void Print(std::string_view text) override;
  void Say(std::string_view text) override;
  void Debug(std::string_view text) override { Write(spdlog::level::debug, text); }
  void Note(std::string_view text) override { Write(spdlog::level::info, text); }
  void Warn(std::string_view text) override { Write(spdlog::level::warn, text); }
  void Show(std::string_view work, double share, std::string_view note) override;
  [[nodiscard]] const volatile bool& interrupted() const noexcept override {
    return *interrupt_.flag();
  }
  void Interrupt() noexcept override { interrupt_.Interrupt(); }

 private:
  void Write(spdlog::level::level_enum level, std::string_view text);

  const Log log_;
  const bool quiet_;
  const MonotonicClock clock_;
  const InterruptGuard interrupt_;
  std::optional<Progress> progress_;
};

}  // namespace twin::cli
