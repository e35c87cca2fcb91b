#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Which of several events at the same instant comes first: the smaller value. A command that
/// arrives exactly at INT's deadline counts as arrived; a controller that deposits exactly when a
/// state arrives is seen by the tick of that state.
enum class EventOrder : std::uint8_t {
  kCommandArrival = 0,
  kOnboardCycle = 1,
  kControllerDone = 2,
  kStateArrival = 3,
  kTickDone = 4,
  kControllerWake = 5,
  kReadBegin = 6,
};

/// Receives an event on the lockstep thread.
class EventHandler {
 public:
  virtual ~EventHandler() = default;
  /// @param now    instant of the event; equals EventQueue::Now().
  /// @param token  the number given to Schedule().
  virtual void OnEvent(Time now, std::uint64_t token) noexcept TWIN_REALTIME = 0;
};

/// The virtual clock of lockstep and everything that is due on it: a fixed-capacity binary heap.
///
/// Events run in order of (time, order, order of scheduling); the last makes equal events
/// repeatable. Time only moves when an event runs, or is moved towards the next one. Source: the
/// project's notes on time (README, "Time").
///
/// Threads: one thread. Real-time: Schedule() and RunNext() allocate nothing; the heap's storage is
/// taken at construction.
class EventQueue final : public Clock {
 public:
  /// @param capacity  most events that may be pending at once; more is a bug of the caller
  /// (checked).
  explicit EventQueue(std::size_t capacity = 4096);

  /// Adds an event. @pre at >= Now(). `handler` must outlive it.
  void Schedule(Time at, EventOrder order, EventHandler& handler,
                std::uint64_t token = 0) noexcept TWIN_REALTIME;

  /// Moves time to the next event and runs it. @returns false when nothing is pending; time then
  /// stays.
  bool RunNext() noexcept TWIN_REALTIME;

  /// When the next event is due; absent when nothing is pending.
  [[nodiscard]] std::optional<Time> NextTime() const noexcept {
    return heap_.empty() ? std::nullopt : std::optional(heap_.front().at);
  }

  /// Moves time forward to `at`, for something that happens then without being an event; never
  /// beyond the next event, never back.
  void AdvanceTo(Time at) noexcept TWIN_REALTIME;

  [[nodiscard]] Time Now() const noexcept override { return now_; }
  [[nodiscard]] std::size_t pending() const noexcept { return heap_.size(); }

 private:
  struct Event {
    Time at;
    std::uint64_t sequence;
    EventHandler* handler;
    std::uint64_t token;
    EventOrder order;
  };
  static bool Later(const Event& a, const Event& b) noexcept;

  std::vector<Event> heap_;
  std::size_t capacity_;
  std::uint64_t next_sequence_ = 0;
  Time now_{};
};

}  // namespace twin::rt
