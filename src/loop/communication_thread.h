#pragma once

#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "loop/motion_watch.h"
#include "twin/backend/backend.h"
#include "twin/core/clock.h"
#include "twin/loop/communication_loop.h"
#include "twin/rt/call_mailbox.h"
#include "twin/rt/latest_value.h"
#include "twin/rt/signal.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// The paper's asynchronous thread: runs a communication loop at real-time priority until Stop().
/// It waits for robot states only (and, in a synchronous loop, for its grid). It executes the calls
/// of other threads between two ticks.
///
/// On a failure (invalid command, lost connection, exception) it first stops the motion, then
/// reports to the watch. If the connection still works, it continues to read, to observe the arm's
/// stop.
///
/// Threads: constructed and destroyed by the supervisor. Real-time: between its first and its last
/// tick it does not allocate, lock, log or throw.
class CommunicationThread {
 public:
  /// Starts the thread and returns once it is set up. All arguments must outlive it.
  /// @param moving  notified at the first state of a motion.
  /// @throws InputError as rt::SetUpThisThread().
  CommunicationThread(const MonotonicClock& clock, CommunicationLoop& loop,
                      backend::Backend& backend, rt::Arrival& arrival, MotionWatch& watch,
                      rt::Signal& moving, const rt::ThreadSettings& settings);

  /// Runs `call` on the thread. @returns false when the thread does not answer.
  [[nodiscard]] bool Execute(rt::Call& call);

  /// The newest state read. Threads: the supervisor's. @pre the watch has a state.
  [[nodiscard]] const RobotState& State() noexcept {
    states_.Refresh();
    return states_.value();
  }

  /// Thread settings that the system did not permit.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Ends the thread; the caller may then use the loop again.
  void Stop();

 private:
  void Run(const std::stop_token& stop) noexcept;
  void Communicate(const std::stop_token& stop);
  void StopMotion(LoopFailure failure) noexcept;

  const MonotonicClock& clock_;
  CommunicationLoop& loop_;
  backend::Backend& backend_;
  rt::Arrival& arrival_;
  MotionWatch& watch_;
  rt::Signal& moving_;

  rt::CallMailbox calls_;
  rt::LatestValue<RobotState> states_;
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::loop
