#pragma once

#include <string>
#include <string_view>

#include "cli/interrupt.h"
#include "cli/log.h"
#include "twin/core/clock.h"
#include "twin/run/console.h"

namespace twin::cli {

/// The terminal of a command: results on standard output, messages in the log, and interrupts.
/// Progress is a bar that is redrawn on a terminal, a line about every tenth otherwise.
class Terminal final : public run::Console {
 public:
  /// @param quiet  neither Print() nor Show() do anything.
  Terminal(Log log, bool quiet);
  /// Ends the bar's line.
  ~Terminal() override { EndLine(); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

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

  /// Whether a user can answer: the standard input is a terminal.
  [[nodiscard]] static bool CanAsk() noexcept;
  /// Shows what will move, waits for Enter, then counts three seconds down.
  /// @throws run::Interrupted on Ctrl-C, also while it counts, and at the end of the input.
  void ConfirmMotion(std::string_view what);

 private:
  /// The piece of work that was shown last.
  struct Progress {
    std::string work;
    int tenths = 0;  ///< lines printed so far
    bool complete = false;
    Time next_draw{};
  };

  void Write(spdlog::level::level_enum level, std::string_view text);
  void DrawBar(double share, std::string_view note);
  void EndLine();
  /// Until a line was typed. @throws run::Interrupted as ConfirmMotion().
  void AwaitEnter() const;

  const Log log_;
  const bool quiet_;
  const bool is_terminal_;
  const MonotonicClock clock_;
  const InterruptGuard interrupt_;
  Progress progress_;
  bool drawn_ = false;  ///< the bar's line is not ended
};

}  // namespace twin::cli
