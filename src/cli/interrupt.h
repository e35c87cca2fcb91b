#pragma once

#include <csignal>

namespace twin::cli {

/// Thrown when the user asked to end while no motion runs.
class Interrupted {};

/// While it lives, SIGINT and SIGTERM set a flag instead of ending the program; a second one of the
/// same kind ends it at once. One at a time.
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
  /// @throws Interrupted when interrupted.
  void ThrowIfInterrupted() const;

 private:
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace twin::cli
