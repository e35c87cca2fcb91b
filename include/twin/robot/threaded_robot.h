#pragma once

#include <cstdint>
#include <functional>
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
#include "twin/core/robot_state.h"
#include "twin/robot/robot.h"
#include "twin/robot/workstation_port.h"
#include "twin/rt/call_mailbox.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/thread_setup.h"

namespace twin::robot {

/// INT's state between two cycles.
struct RobotReport {
  RobotMode mode = RobotMode::kOther;
  LastMotion last_motion;
  onboard::Violations found;  ///< Robot::last_found
};

/// An emulated robot on its own thread: a Robot, its event queue, and requests from other threads.
/// Derived classes advance the time.
///
///     other threads: Move(), ... ---> CallMailbox, between two events ---> the robot's thread
///
/// Before Begin() and after End() the robot's time stands still: requests are served at once,
/// commands are lost.
///
/// Threads: Begin() and End() from one; requests from any, serialised.
class ThreadedRobot : protected rt::EventHandler {
 public:
  /// @pre the destructor of the most derived class has called End().
  ~ThreadedRobot() override = default;
  ThreadedRobot(const ThreadedRobot&) = delete;
  ThreadedRobot& operator=(const ThreadedRobot&) = delete;

  /// Starts thread and cycles; the first is due one period after thread setup. Once. On a shared
  /// thread they begin when that is started. @throws InputError as rt::SetUpThisThread.
  void Begin();
  /// Stops them; afterwards no record is put and no state arrives. A second call has no effect. A
  /// shared thread stops with all that run on it.
  void End();

  /// @throws RobotFault, as all requests, when the robot's thread does not answer in time; the
  /// request then never takes effect.
  [[nodiscard]] MoveStatus Move(const MotionModes& modes);
  void StopMove();
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery();
  [[nodiscard]] SetterStatus Configure(const Setting& setting);
  [[nodiscard]] bool Operate(PanelAction action);
  /// As in Robot, between two cycles.
  void StandBy();
  /// As in Robot, between two cycles.
  std::optional<plant::Overlap> Place(int body, const Transform& X_WB);
  /// As in Robot.
  [[nodiscard]] bool has_hand() const noexcept { return robot_.has_hand(); }
  /// @pre has_hand()
  [[nodiscard]] HandDevice hand_device() const noexcept {
    return plant::DeviceOf(robot_.config().plant.hand);
  }
  [[nodiscard]] HandStart StartHand(const HandCommand& command);
  [[nodiscard]] std::optional<HandResult> HandOutcome(HandTicket ticket) const;
  [[nodiscard]] HandState hand_state() const;
  /// As in Robot; requests and state bypass the robot's thread.
  [[nodiscard]] BaseUnit* base() noexcept { return robot_.base(); }
  [[nodiscard]] RobotMode mode() const;
  [[nodiscard]] LastMotion last_motion() const;
  /// Robot::guard. Threads: any.
  [[nodiscard]] const model::LabLimits& guard() const noexcept { return robot_.guard(); }
  [[nodiscard]] RobotReport report() const;
  /// As in Robot; message_id counts cycles.
  [[nodiscard]] RobotState state() const;
  /// True if a cycle of a motion waits for the answer to the state before. Threads: any.
  [[nodiscard]] virtual bool is_answer_paced() const noexcept { return false; }

  /// Permissions that the thread lacked. @pre not between Begin() and End().
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

 protected:
  /// Requests that INT grants.
  enum class Granted : std::uint8_t {
    kMove,
    kStopMove,
    kRecovery,
    kSetting,
    kPanelAction,
    kPlace,
    kReset,
  };

  /// @param port    to the workstation; must outlive the robot.
  /// @param clock   of the host; must outlive the robot.
  /// @param thread  setup of the robot's thread, or the thread that it shares with other robots,
  /// whose plants may then be arms of one model (plant::SharedModel); that must outlive the robot.
  /// @param plant, sink  as in Robot; the robot's thread puts sink's cycle records.
  /// @param timeout  of a request to the robot's thread.
  /// @throws InputError as Robot.
  ThreadedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                WorkstationPort& port, const MonotonicClock& clock, rt::ThreadSettings thread,
                record::RecordSink* sink, Duration timeout);
  /// Body of the robot's thread, until `stop` is requested.
  virtual void Run(const std::stop_token& stop) noexcept = 0;
  /// INT has granted a request; called before the reply. On the robot's thread, or while it does
  /// not exist.
  virtual void OnGranted(Granted /*what*/) noexcept {}

  /// Calls `action`, which may take the robot back, on the robot's thread, unless in a motion or
  /// while the hand is busy. How the last motion and the hand's commands ended is kept for those
  /// who have not asked yet. @returns whether it was called.
  [[nodiscard]] bool BetweenMotions(const std::function<void()>& action);

  /// On the robot's thread, like those below.
  [[nodiscard]] Robot& robot() noexcept { return robot_; }
  [[nodiscard]] const Robot& robot() const noexcept { return robot_; }
  [[nodiscard]] rt::EventQueue& events() noexcept { return events_; }
  [[nodiscard]] WorkstationPort& port() noexcept { return port_; }
  [[nodiscard]] const MonotonicClock& clock() const noexcept { return clock_; }
  [[nodiscard]] bool shares_thread() const noexcept { return thread_settings_.shared != nullptr; }
  /// Whether the hand executes a command.
  [[nodiscard]] bool hand_is_busy() const noexcept {
    return hand_ticket_ != hand_before_ && !robot_.HandOutcome(hand_ticket_ - hand_offset_);
  }
  void RunCalls() noexcept TWIN_REALTIME { calls_.RunPending(); }
  /// Returns at once if it has passed. Robots that share the thread go on meanwhile.
  void SleepUntil(Time deadline) noexcept TWIN_REALTIME;
  /// Discards messages received before Begin().
  void DropCommands() noexcept;

 private:
  [[nodiscard]] LastMotion LastEnd() const noexcept;
  /// @param ticket  of StartHand().
  [[nodiscard]] std::optional<HandResult> OutcomeOf(HandTicket ticket) const noexcept;
  template <typename Request>
  std::invoke_result_t<Request> Ask(Request request) const;

  const MonotonicClock& clock_;
  const rt::ThreadSettings thread_settings_;
  const Duration timeout_;
  WorkstationPort& port_;
  rt::EventQueue events_;
  Robot robot_;
  HandTicket hand_ticket_ = 0;  ///< of the last command started; it rises over BetweenMotions()
  HandTicket hand_offset_ = 0;  ///< of such tickets from the hand's own
  HandTicket hand_before_ = 0;  ///< the last one before BetweenMotions()
  std::optional<HandResult> hand_end_{};    ///< of that one
  std::optional<LastMotion> motion_end_{};  ///< before BetweenMotions(), until the next motion

  mutable std::mutex requests_;  ///< serialises requests; the robot's thread never locks it
  mutable rt::CallMailbox calls_;
  bool running_ = false;  ///< guarded by requests_
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::robot
