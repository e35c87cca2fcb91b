#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Order of events at the same instant: the smaller value first. So a command that arrives exactly
/// at INT's deadline counts, and a tick sees what a controller deposits exactly when its state
/// arrives.
enum class EventOrder : std::uint8_t {
  kCommandArrival = 0,
  kOnboardCycle = 1,
  kControllerDone = 2,
  kStateArrival = 3,
  kTickDone = 4,
  kControllerWake = 5,
  kReadBegin = 6,
};

/// Handles an event on the lockstep thread.
class EventHandler {
 public:
  virtual ~EventHandler() = default;
  /// @param now    time of the event; equals EventQueue::Now().
  /// @param token  as given to Schedule().
  virtual void OnEvent(Time now, std::uint64_t token) noexcept TWIN_REALTIME = 0;
};

/// The virtual clock of lockstep and its pending events: a binary heap of fixed capacity.
///
/// Events run in the order (time, order, order of scheduling); the last makes ties repeatable. Time
/// advances only when an event runs, or by AdvanceTo(). Source: the project's notes on time
/// (README, "Time").
///
/// Threads: one thread. Real-time: Schedule() and RunNext() allocate nothing; the constructor
/// reserves the heap's storage.
class EventQueue final : public Clock {
 public:
  /// @param capacity  most events pending at once; more is a bug of the caller (checked).
  explicit EventQueue(std::size_t capacity = 4096);

  /// Adds an event. @pre at >= Now(). `handler` must outlive it.
  void Schedule(Time at, EventOrder order, EventHandler& handler,
                std::uint64_t token = 0) noexcept TWIN_REALTIME;

  /// Moves time to the next event and runs it. @returns false, without moving time, if none is
  /// pending.
  bool RunNext() noexcept TWIN_REALTIME;

  /// Time of the next event; nullopt if none is pending.
  [[nodiscard]] std::optional<Time> NextTime() const noexcept {
    return heap_.empty() ? std::nullopt : std::optional(heap_.front().at);
  }

  /// Moves time forward to `at`, for something that happens then without an event; never beyond the
  /// next event, never back.
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
