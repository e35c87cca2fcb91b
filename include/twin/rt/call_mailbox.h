#pragma once

#include <atomic>
#include <type_traits>
#include <utility>
#include <variant>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/rt/signal.h"

namespace twin::rt {

/// A call for another thread to execute.
class Call {
 public:
  virtual ~Call() = default;
  /// Runs on the other thread. Real-time: noexcept, allocates nothing.
  virtual void Run() noexcept TWIN_REALTIME = 0;
};

/// Wraps a function as a call and keeps its result. @tparam Function  noexcept; returns void or a
/// default-constructible value.
template <typename Function>
class FunctionCall final : public Call {
 public:
  using Answer = std::invoke_result_t<Function>;

  explicit FunctionCall(Function function) : function_(std::move(function)) {}
  void Run() noexcept override {
    if constexpr (std::is_void_v<Answer>) {
      function_();
    } else {
      answer_ = function_();
    }
  }
  [[nodiscard]] auto answer() const noexcept { return answer_; }

 private:
  Function function_;
  std::conditional_t<std::is_void_v<Answer>, std::monostate, Answer> answer_{};
};

/// Passes calls to a real-time thread, which runs them between two cycles, and waits for their
/// completion. Requests reach INT this way without a lock.
///
///     Execute(call): slot_ <- &call, wait on done_    RunPending(): c <- slot_, c->Run(), done_
///                    timed out: &call <- slot_
///
/// The side that takes the address out of slot_ owns the call. If it is the real-time thread, the
/// call runs, and the requester waits for its end. If it is the requester, after a timeout, the
/// call never runs.
///
/// Threads: Execute() from one thread, RunPending() from the real-time thread; the mailbox outlives
/// both. Real-time: RunPending() is noexcept, wait-free except for waking the requester, and
/// allocates nothing.
class CallMailbox {
 public:
  /// @param clock  of timeouts; must outlive the mailbox.
  explicit CallMailbox(const MonotonicClock& clock) : clock_(clock), done_(clock) {}

  /// @returns true once `call` has run; false if it did not start within `timeout`.
  [[nodiscard]] bool Execute(Call& call, Duration timeout);

  /// Runs the waiting call, if any.
  void RunPending() noexcept TWIN_REALTIME;

 private:
  const MonotonicClock& clock_;
  std::atomic<Call*> slot_{nullptr};
  Signal done_;
};

}  // namespace twin::rt
