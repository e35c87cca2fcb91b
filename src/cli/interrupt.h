#pragma once

#include <array>
#include <csignal>

#include "twin/run/console.h"

namespace twin::cli {

using run::Interrupted;

/// While it lives, SIGINT, SIGTERM and SIGHUP (unless that is ignored, as under nohup) set a flag
/// instead of ending the program; a second one of the same kind ends it at once. What waits for
/// children then gives up (rt::GiveUpWhen). Of several, one in the other, they are the first one's.
///
/// Threads: main thread.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] bool interrupted() const noexcept;
  /// What a run polls.
  [[nodiscard]] const volatile bool* flag() const noexcept;
  /// As if the user had asked for it, once or more. Threads: any.
  void Interrupt() const noexcept;
  /// From here on as if no signal had come: for work after the user ended what ran before.
  void Rearm() const;
  /// @throws Interrupted when interrupted.
  void ThrowIfInterrupted() const;

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> old_{};
};

/// Whether the user wanted to end, also after the last guard's life: the end is then still to be
/// told. Threads: any.
[[nodiscard]] bool WasInterrupted() noexcept;

}  // namespace twin::cli
