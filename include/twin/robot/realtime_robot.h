#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/robot/robot.h"
#include "twin/rt/arrival.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/errand.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/latest_value.h"
#include "twin/rt/signal.h"
#include "twin/rt/spsc_ring.h"
#include "twin/rt/thread_setup.h"

namespace twin::robot {

/// A whole emulated robot on the wall clock: a Robot and its event queue, worked off by a thread of
/// its own. INT, plant and link are those of lockstep; a delay of the link is really waited for.
///
///     workstation's threads                  the robot's thread: sleep until the next event is due
///     Write() ---> ring of {command, when} ---> CommandLink ---> INT, plant
///     Read()  <--- LatestValue + Signal    <--- StateLink   <-----+
///     Move(), ... ---> ErrandBox, between two events ------------->
///
/// What is due runs in order of its time: a command enters the link at the instant of its Write(),
/// after all that was due before. A cycle that would begin more than 0.25 ms late is postponed by
/// as much, and all after it: two cycles are never much closer than a period, nothing is caught up,
/// and the whole periods among it are counted.
///
/// Before Begin() and after End() no time passes for the robot: requests are answered at once,
/// commands are lost.
///
/// Threads: Begin(), End() and the figures from one; Read() and Write() from one (the tick's), or
/// one each; requests from any, one waits for the other. Real-time: Read() and Write() are
/// noexcept, lock nothing, allocate nothing; so is the robot's thread between Begin() and End().
class RealtimeRobot final : private rt::EventHandler {
 public:
  /// @param clock   of the run; must outlive the robot.
  /// @param thread  of the robot's thread.
  /// @param plant, sink  as Robot; sink's cycle records are put on the robot's thread.
  /// @throws InputError as Robot.
  RealtimeRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                const MonotonicClock& clock, rt::ThreadSettings thread, rt::RecordSink* sink);
  ~RealtimeRobot() override { End(); }
  RealtimeRobot(const RealtimeRobot&) = delete;
  RealtimeRobot& operator=(const RealtimeRobot&) = delete;

  /// Starts thread and cycles; the first is due one period from when the thread is set up. Once.
  /// @throws InputError as rt::SetUpThisThread.
  void Begin();
  /// Ends them; no record is put and no state arrives after it returns. More than once: no effect.
  void End();

  /// @throws RobotFault when the robot's thread has not answered within 1 s, as all requests; it
  /// then has not done and will not do what was asked.
  [[nodiscard]] MoveStatus Move(const MotionModes& modes);
  void StopMove();
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery();
  [[nodiscard]] SetterStatus Configure(const Setting& setting);
  [[nodiscard]] bool Operate(PanelAction action);
  /// As Robot's.
  [[nodiscard]] bool has_hand() const noexcept { return robot_.has_hand(); }
  [[nodiscard]] HandStart StartHand(const HandCommand& command);
  [[nodiscard]] std::optional<HandResult> HandOutcome(HandTicket ticket) const;
  [[nodiscard]] HandState hand_state() const;
  [[nodiscard]] RobotMode mode() const;
  [[nodiscard]] LastMotion last_motion() const;

  /// Puts a command on the way, as of now. When the robot's thread has left kCommands waiting, it
  /// is lost, as on the wire.
  void Write(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The newest state that has arrived since the last call, or null; valid until the next call.
  [[nodiscard]] const RobotState* Read() noexcept TWIN_REALTIME {
    return states_.Refresh() ? &states_.value() : nullptr;
  }
  /// Where to wait for the next state.
  [[nodiscard]] rt::Arrival& arrival() noexcept { return arrival_; }

  /// Begin of a cycle after its deadline, in which periods it was postponed by are contained.
  /// @pre this and the following: not between Begin() and End().
  [[nodiscard]] const rt::DurationHistogram& lateness() const noexcept { return lateness_; }
  /// Whole periods that were skipped.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }
  /// What the thread was not permitted.
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }
  /// Commands lost because the ring was full. Any time.
  [[nodiscard]] std::uint64_t commands_lost() const noexcept {
    return commands_lost_.load(std::memory_order_relaxed);  // a count, nothing hangs on it
  }

 private:
  /// Commands that may wait for the robot's thread: one a cycle, with room for a stall.
  static constexpr std::size_t kCommands = 64;

  struct Written {
    RobotCommand command;
    Time at{};
  };

  void OnEvent(Time now, std::uint64_t message_id) noexcept override;
  void Run(const std::stop_token& stop) noexcept;
  void WorkOff(Time now) noexcept TWIN_REALTIME;
  void RunEventsUntil(Time until) noexcept TWIN_REALTIME;
  void PostponeIfStalled(Time now) noexcept TWIN_REALTIME;
  template <typename Request>
  std::invoke_result_t<Request> Ask(Request request) const;

  const MonotonicClock& clock_;
  const rt::ThreadSettings thread_settings_;
  rt::EventQueue events_;
  Robot robot_;

  rt::SpscRing<Written> commands_{kCommands};
  std::atomic<std::uint64_t> commands_lost_{0};
  rt::LatestValue<RobotState> states_;
  rt::Signal arrival_;

  mutable std::mutex requests_;  ///< between those who ask; the robot's thread never takes it
  mutable rt::ErrandBox errands_;
  bool running_ = false;  ///< guarded by requests_

  rt::DurationHistogram lateness_;
  std::uint64_t overruns_ = 0;
  Duration postponed_{};  ///< the next cycle, so far
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::robot
