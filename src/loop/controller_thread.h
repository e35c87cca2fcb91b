#pragma once

#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "loop/motion_watch.h"
#include "twin/core/clock.h"
#include "twin/loop/controller_loop.h"
#include "twin/rt/signal.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// Runs the controller beside the communication thread, on the controller's own grid, from the
/// first state of the motion until Stop().
///
/// Threads: constructed, stopped and destroyed by the supervisor.
class ControllerThread {
 public:
  /// Starts the thread and returns once it is set up. @throws InputError as rt::SetUpThisThread().
  /// @param moving  notified at the first state of the motion; this thread waits on it.
  ControllerThread(const MonotonicClock& clock, ControllerLoop& loop, const MotionWatch& watch,
                   rt::Signal& moving, const rt::ThreadSettings& settings);

  /// Thread settings that the system did not permit.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Ends the thread; after return no update runs or begins.
  void Stop();

 private:
  void Run(const std::stop_token& stop) noexcept;

  const MonotonicClock& clock_;
  ControllerLoop& loop_;
  const MotionWatch& watch_;
  rt::Signal& wake_;
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::loop
