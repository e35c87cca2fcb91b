#pragma once

#include <barrier>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "twin/core/clock.h"
#include "twin/rt/fiber_thread.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// The wall clock of several simulated robots that share a thread. Their runs have threads of their
/// own; time begins for all of them when the last is ready, and ends when the last has ended, so
/// that a robot whose run is over holds its position meanwhile.
///
///     Seat, Seat, ... -> [get ready, one after the other] -> Begin() -> ... -> End()
///
/// Threads: each Seat on its own.
class SharedTime {
 public:
  class Seat;

  /// @param robots  number of seats that there will be. @param thread  setup of the robots' thread.
  /// @param on_stop  as FiberThread's.
  SharedTime(std::size_t robots, rt::ThreadSettings thread, std::function<void()> on_stop);

  /// Permissions that the robots' thread lacked. @pre time has ended for all.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

 private:
  /// Called by the barrier once all robots have arrived.
  struct Next {
    SharedTime* time;
    void operator()() noexcept { time->Advance(); }
  };
  void Advance() noexcept;

  const std::shared_ptr<MonotonicClock> clock_ = std::make_shared<MonotonicClock>();
  rt::FiberThread thread_;
  std::mutex ready_;  ///< held by the robot that gets ready
  bool runs_ = false;
  std::exception_ptr failure_;
  std::vector<std::string> notices_;
  std::barrier<Next> all_;
};

/// One robot's part. From construction to Begin() no other robot gets ready.
///
/// Threads: one.
class SharedTime::Seat {
 public:
  /// Waits until no other robot gets ready. @param time  must outlive this.
  /// @param on_end  called in End(), before it waits for the others; may be empty.
  Seat(SharedTime& time, std::function<void()> on_end);
  /// Leaves: the others wait for this robot no more.
  ~Seat();
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

  /// Counts from the common beginning.
  [[nodiscard]] const std::shared_ptr<MonotonicClock>& clock() const noexcept {
    return time_.clock_;
  }
  [[nodiscard]] rt::FiberThread& thread() const noexcept { return time_.thread_; }

  /// Waits until all are ready; then time begins. Once. @pre the robot is on the thread.
  /// @throws as FiberThread::Start.
  void Begin();
  /// Waits until time has ended for all; the thread has then stopped. A second call, and one
  /// without Begin(), has no effect.
  void End();
  /// How long End() has waited for the others.
  [[nodiscard]] Duration waited() const noexcept { return waited_; }

 private:
  SharedTime& time_;
  const std::function<void()> on_end_;
  std::unique_lock<std::mutex> ready_;
  bool has_begun_ = false;
  bool has_ended_ = false;
  Duration waited_{};
};

}  // namespace twin::loop
