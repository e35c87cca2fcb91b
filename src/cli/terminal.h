#pragma once

#include <optional>
#include <string_view>

#include "cli/interrupt.h"
#include "cli/progress.h"
#include "twin/core/clock.h"
#include "twin/run/console.h"

namespace twin::cli {

/// The terminal of a run: standard output and error, and what interrupts it.
class Terminal final : public run::Console {
 public:
  /// @param quiet  neither Print() nor Show() do anything.
  explicit Terminal(bool quiet) : quiet_(quiet) {}

  void Print(std::string_view text) override;
  void Say(std::string_view text) override;
  void Note(std::string_view text) override;
  void Warn(std::string_view text) override;
  void Show(std::string_view work, double share, std::string_view note) override;
  [[nodiscard]] const volatile bool& interrupted() const noexcept override {
    return *interrupt_.flag();
  }
  void Interrupt() noexcept override { interrupt_.Interrupt(); }

 private:
  const bool quiet_;
  const MonotonicClock clock_;
  const InterruptGuard interrupt_;
  std::optional<Progress> progress_;
};

}  // namespace twin::cli
