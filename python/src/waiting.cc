#include "waiting.h"

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "bindings.h"
#include "twin/rt/child_process.h"

namespace twin::python {
namespace {

/// Children are given up for the whole process, so only the thread does so that Python interrupts.
class GivingUp {
 public:
  explicit GivingUp(const volatile bool& interrupted) : is_main_(::getpid() == ::gettid()) {
    if (is_main_) rt::GiveUpWhen(&interrupted);
  }
  ~GivingUp() {
    if (is_main_) rt::GiveUpWhen(nullptr);
  }
  GivingUp(const GivingUp&) = delete;
  GivingUp& operator=(const GivingUp&) = delete;

 private:
  const bool is_main_;
};

/// A thread that does one thing, and how it ended.
class Worker {
 public:
  explicit Worker(const std::function<void()>& work) : thread_([this, &work] { Do(work); }) {}
  ~Worker() { thread_.join(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// @returns whether it has ended.
  [[nodiscard]] bool Wait(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, limit, [this] { return has_ended_; });
  }
  /// What it threw; null: nothing. @pre it has ended.
  [[nodiscard]] const std::exception_ptr& thrown() const noexcept { return thrown_; }

 private:
  void Do(const std::function<void()>& work) noexcept {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::scoped_lock lock(mutex_);
    thrown_ = thrown;
    has_ended_ = true;
    ended_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::exception_ptr thrown_;
  std::thread thread_;  // last: it uses the others
};

void HandleSignals() {
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

}  // namespace

void DoAndWait(volatile bool& interrupted, const std::function<void()>& work,
               const std::function<void()>& attend) {
  static constexpr std::chrono::milliseconds kLook(50);
  const CallInFlight in_flight;
  const GivingUp giving_up(interrupted);
  std::exception_ptr raised;
  std::exception_ptr thrown;
  {
    Worker worker(work);
    const auto wait = [&worker, &interrupted] {
      const GilReleased released;
      bool has_ended = worker.Wait(kLook);
      while (!has_ended && InterpreterEnds()) {
        interrupted = true;
        has_ended = worker.Wait(kLook);
      }
      return has_ended;
    };
    while (!wait()) {
      if (raised) continue;  // it is winding down
      try {
        HandleSignals();
        if (attend) attend();
      } catch (...) {
        raised = std::current_exception();
        interrupted = true;
      }
    }
    thrown = worker.thrown();
  }
  if (raised) std::rethrow_exception(raised);
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace twin::python
