#pragma once

#include <exception>

#include "bindings.h"
#include "twin/core/clock.h"

namespace twin::python {

/// Handles Python's signals while a call computes with the GIL released. What a handler raises, as
/// that of Ctrl-C does, sets interrupted(), and Rethrow() raises it once the call has stopped.
/// Signals are handled on the main thread; on others Look() does nothing but take the GIL.
///
/// Threads: one at a time.
class SignalWatch {
 public:
  /// At least every 50 ms, and as often as one likes. @pre the GIL is released.
  void Look() {
    const Time now = clock_.Now();
    if (interrupted_ || now < next_) return;
    next_ = now + kPeriod;
    if (InterpreterEnds()) return Interrupt([] { ThrowInterpreterEnds(); });
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() == 0) return;
    Interrupt([] { throw nb::python_error(); });
  }

  /// Interrupts the call as a signal does; on the thread that makes it.
  void Stop() noexcept { interrupted_ = true; }

  [[nodiscard]] const volatile bool& interrupted() const noexcept { return interrupted_; }

  /// Throws what was raised, once; nothing otherwise.
  void Rethrow() {
    interrupted_ = false;
    if (raised_) std::rethrow_exception(std::exchange(raised_, nullptr));
  }

 private:
  template <typename Throw>
  void Interrupt(Throw raise) {
    try {
      raise();
    } catch (...) {
      raised_ = std::current_exception();
    }
    interrupted_ = true;
  }

  static constexpr Duration kPeriod = std::chrono::milliseconds(50);

  const MonotonicClock clock_;
  Time next_{};
  volatile bool interrupted_ = false;
  std::exception_ptr raised_;
};

}  // namespace twin::python
