#pragma once

#include <nanobind/nanobind.h>

namespace twin::python {

/// Releases the GIL while it lives. When the interpreter ends, a thread that would take it back
/// stays in the destructor for good: Python would end it, through frames that no exception may
/// leave (PyEval_RestoreThread, up to Python 3.13), which aborts the process.
///
/// @pre the GIL is held.
class GilReleased {
 public:
  GilReleased();
  ~GilReleased();
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;

 private:
  PyThreadState* state_;
};

/// A call that the interpreter's end waits for, as it does for GilReleased, between two of those.
class CallInFlight {
 public:
  CallInFlight() noexcept;
  ~CallInFlight();
  CallInFlight(const CallInFlight&) = delete;
  CallInFlight& operator=(const CallInFlight&) = delete;
};

/// Whether the interpreter ends and the calling thread is not the one that ends it: what it
/// computes is to be broken off. Threads: any.
[[nodiscard]] bool InterpreterEnds() noexcept;

/// What is thrown then, for nobody to see.
[[noreturn]] void ThrowInterpreterEnds();

/// Registers with Python's atexit that calls of daemon threads are broken off and waited for, for
/// at most 5 s.
void AwaitCallsAtExit();

}  // namespace twin::python
