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

/// The paper's asynchronous thread: runs a communication loop, and nothing else, at real-time
/// priority, until it is stopped. It waits for robot states only (and, in a synchronous loop, for
/// its own grid); what others want of it are calls between two ticks.
///
/// When it fails (a command that must not be sent, connection gone, an exception) it first stops
/// the motion, then tells the watch; the connection permitting, it goes on reading, so that the
/// arm's stop is seen.
///
/// Threads: constructed and destroyed by the onlooker. Real-time: between its first and its last
/// tick it allocates nothing, takes no lock, writes no log and throws nothing.
class CommunicationThread {
 public:
  /// Starts the thread, and returns when it is set up. Everything must outlive it.
  /// @param moving  notified at the first state of a motion.
  /// @throws InputError as rt::SetUpThisThread.
  CommunicationThread(const MonotonicClock& clock, CommunicationLoop& loop,
                      backend::Backend& backend, rt::Arrival& arrival, MotionWatch& watch,
                      rt::Signal& moving, const rt::ThreadSettings& settings);

  /// Runs `call` on the thread. @returns false when the thread does not answer.
  [[nodiscard]] bool Execute(rt::Call& call);

  /// Onlooker. The newest state that was read. @pre the watch has one.
  [[nodiscard]] const RobotState& State() noexcept {
    states_.Refresh();
    return states_.value();
  }

  /// What the thread was not permitted.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

  /// Ends the thread; the loop is the caller's again.
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
