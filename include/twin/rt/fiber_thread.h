#pragma once

#include <deque>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/rt/thread_setup.h"

namespace twin::rt {

/// One thread for several functions that would each have one: each runs on a fiber (fiber.h) until
/// it sleeps, or gives way. Those that are due run in the order in which they were added.
///
///     construct -> Add, Add, ... -> Start -> Stop
///
/// Threads: Add() and Start() from one; Stop() from any, one at a time; the others within the
/// functions. Real-time: SleepUntil() and GiveWay() allocate nothing and take no lock.
class FiberThread {
 public:
  using Body = std::function<void(const std::stop_token& stop)>;

  /// @param on_stop  called on this thread before the functions learn that they must stop, so that
  /// none waits for another; may be empty. Must not throw.
  FiberThread(ThreadSettings settings, std::function<void()> on_stop);
  ~FiberThread();
  FiberThread(const FiberThread&) = delete;
  FiberThread& operator=(const FiberThread&) = delete;

  /// @param body  which must not throw, and returns soon after `stop` is requested.
  /// @throws EnvironmentError as Fiber. @pre not yet started.
  void Add(Body body);
  /// Returns after the thread's setup. @returns as SetUpThisThread. @throws as it.
  [[nodiscard]] std::vector<std::string> Start();
  /// Stops all functions and waits for their end. A second call has no effect.
  void Stop();

  /// As rt::SleepUntil for a function of a FiberThread: the others go on meanwhile.
  static void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept TWIN_REALTIME;
  /// Lets the others run that are due, for a function that waits for one of them.
  static void GiveWay() noexcept TWIN_REALTIME;

 private:
  struct Seat;

  void Run(const std::stop_token& stop) noexcept;
  /// Runs those that are due, then those that gave way, once each.
  void RunDue() noexcept TWIN_REALTIME;
  void Resume(Seat& seat) noexcept TWIN_REALTIME;
  /// A cycle at most.
  void SleepUntilNext() noexcept TWIN_REALTIME;

  const MonotonicClock clock_;
  const ThreadSettings settings_;
  const std::function<void()> on_stop_;
  std::deque<Seat> seats_;
  Seat* running_ = nullptr;
  std::stop_source stop_;  ///< of the functions
  std::jthread thread_;
};

}  // namespace twin::rt
