#include "gil.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <stdexcept>

#include "twin/rt/host_time.h"

namespace twin::python {
namespace {

namespace nb = nanobind;

std::atomic<pid_t> ending_thread = 0;  ///< that ends the interpreter; 0: it does not end
std::atomic<int> in_flight = 0;        ///< calls of all threads
thread_local int own_in_flight = 0;

void Count(int calls) noexcept {
  in_flight += calls;
  own_in_flight += calls;
}

[[noreturn]] void StayForGood() noexcept {
  Count(-own_in_flight);
  while (true) ::pause();
}

void EndCalls() {
  if (nb::cast<int>(nb::module_::import_("threading").attr("active_count")()) == 1) return;
  nb::set_leak_warnings(false);  // daemon threads keep what they have
  ending_thread = ::gettid();
  const nb::gil_scoped_release released;  // calls that take it go on to their end
  constexpr auto kLook = std::chrono::milliseconds(10);
  constexpr int kMostLooks = 500;
  for (int look = 0; look < kMostLooks && in_flight > own_in_flight; ++look) rt::Pause(kLook);
}

}  // namespace

GilReleased::GilReleased() : state_(PyEval_SaveThread()) {
  Count(1);
  if (InterpreterEnds()) StayForGood();
}

GilReleased::~GilReleased() {
  if (InterpreterEnds()) StayForGood();
  PyEval_RestoreThread(state_);
  Count(-1);
}

CallInFlight::CallInFlight() noexcept {
  Count(1);
}

CallInFlight::~CallInFlight() {
  Count(-1);
}

bool InterpreterEnds() noexcept {
  const pid_t ending = ending_thread;
  return ending != 0 && ending != ::gettid();
}

void ThrowInterpreterEnds() {
  throw std::runtime_error("the interpreter ends");
}

void AwaitCallsAtExit() {
  ::pthread_atfork(nullptr, nullptr, [] { in_flight = own_in_flight; });
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&EndCalls));
}

}  // namespace twin::python
