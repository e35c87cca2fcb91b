#pragma once

#include <atomic>
#include <type_traits>
#include <utility>
#include <variant>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/rt/signal.h"

namespace twin::rt {

/// Something one thread wants done by another.
class Errand {
 public:
  virtual ~Errand() = default;
  /// Runs on the other thread. Real-time: noexcept, allocates nothing.
  virtual void Run() noexcept TWIN_REALTIME = 0;
};

/// A call as an errand, and its answer once it has run. @tparam Call  noexcept, returns nothing or
/// something with a default value.
template <typename Call>
class CallErrand final : public Errand {
 public:
  using Answer = std::invoke_result_t<Call>;

  explicit CallErrand(Call call) : call_(std::move(call)) {}
  void Run() noexcept override {
    if constexpr (std::is_void_v<Answer>) {
      call_();
    } else {
      answer_ = call_();
    }
  }
  [[nodiscard]] auto answer() const noexcept { return answer_; }

 private:
  Call call_;
  std::conditional_t<std::is_void_v<Answer>, std::monostate, Answer> answer_{};
};

/// Hands errands to a real-time thread, which runs them where it suits it (between two cycles), and
/// waits for them: how requests reach INT without a lock.
///
///     Do(errand): slot_ <- &errand, wait on done_        RunPending(): e <- slot_, e->Run(), done_
///                 out of patience: &errand <- slot_
///
/// Whoever takes the address out of slot_ has the errand: either it is run, or the requester that
/// ran out of patience takes it back; it then has not run and never will. One that has begun is
/// waited for to its end.
///
/// Threads: Do() from one thread, RunPending() from the real-time thread; the box outlives both's
/// use. Real-time: RunPending() is noexcept, wait-free but for waking the requester, allocates
/// nothing.
class ErrandBox {
 public:
  /// @param clock  the requester's patience is of this clock; must outlive the box.
  explicit ErrandBox(const MonotonicClock& clock) : clock_(clock), done_(clock) {}

  /// @returns true once `errand` has run; false when it was not begun within `patience`.
  [[nodiscard]] bool Do(Errand& errand, Duration patience);

  /// Runs the errand that waits, if any.
  void RunPending() noexcept TWIN_REALTIME;

 private:
  const MonotonicClock& clock_;
  std::atomic<Errand*> slot_{nullptr};
  Signal done_;
};

}  // namespace twin::rt
