#pragma once

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
#include "twin/robot/workstation_port.h"
#include "twin/rt/call_mailbox.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/thread_setup.h"

namespace twin::robot {

/// What INT tells of itself between two cycles, at one instant.
struct RobotReport {
  RobotMode mode = RobotMode::kOther;
  LastMotion last_motion;
  onboard::Violations found;  ///< Robot::last_found
};

/// A whole emulated robot on a thread of its own: a Robot and its event queue, and how other
/// threads ask something of it. Who advances its time is decided by what derives from it.
///
///     other threads: Move(), ... ---> CallMailbox, between two events ---> the robot's thread
///
/// Before Begin() and after End() no time passes for the robot: requests are answered at once,
/// commands are lost.
///
/// Threads: Begin() and End() from one; requests from any, one waits for the other.
class ThreadedRobot : protected rt::EventHandler {
 public:
  /// @pre the destructor of the object's own class, the first to run, has called End().
  ~ThreadedRobot() override = default;
  ThreadedRobot(const ThreadedRobot&) = delete;
  ThreadedRobot& operator=(const ThreadedRobot&) = delete;

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
  /// As Robot's: its requests and its state are exchanged without the robot's thread.
  [[nodiscard]] BaseUnit* base() noexcept { return robot_.base(); }
  [[nodiscard]] RobotMode mode() const;
  [[nodiscard]] LastMotion last_motion() const;
  [[nodiscard]] RobotReport report() const;

  /// What the thread was not permitted. @pre not between Begin() and End().
  [[nodiscard]] const std::vector<std::string>& notices() const noexcept { return notices_; }

 protected:
  /// A request that INT has granted.
  enum class Granted : std::uint8_t { kMove, kStopMove, kRecovery, kSetting, kPanelAction };

  /// @param port    to the workstation; must outlive the robot.
  /// @param clock   of the host; must outlive the robot.
  /// @param thread  of the robot's thread.
  /// @param plant, sink  as Robot; sink's cycle records are put on the robot's thread.
  /// @throws InputError as Robot.
  ThreadedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                WorkstationPort& port, const MonotonicClock& clock, rt::ThreadSettings thread,
                rt::RecordSink* sink);
  /// The work of the robot's thread, until `stop` asks for its end.
  virtual void Run(const std::stop_token& stop) noexcept = 0;
  /// INT has granted a request just now, before whoever asked knows. On the robot's thread, or
  /// while there is none.
  virtual void OnGranted(Granted /*what*/) noexcept {}

  /// On the robot's thread, as the following.
  [[nodiscard]] Robot& robot() noexcept { return robot_; }
  [[nodiscard]] const Robot& robot() const noexcept { return robot_; }
  [[nodiscard]] rt::EventQueue& events() noexcept { return events_; }
  [[nodiscard]] WorkstationPort& port() noexcept { return port_; }
  [[nodiscard]] const MonotonicClock& clock() const noexcept { return clock_; }
  /// Whether a command of the hand runs.
  [[nodiscard]] bool hand_is_busy() const noexcept {
    return hand_ticket_ != 0 && !robot_.HandOutcome(hand_ticket_);
  }
  void RunCalls() noexcept TWIN_REALTIME { calls_.RunPending(); }
  /// Throws away what came before there was a robot.
  void DropCommands() noexcept;

 private:
  template <typename Request>
  std::invoke_result_t<Request> Ask(Request request) const;

  const MonotonicClock& clock_;
  const rt::ThreadSettings thread_settings_;
  WorkstationPort& port_;
  rt::EventQueue events_;
  Robot robot_;
  HandTicket hand_ticket_ = 0;  ///< of the last command that was started

  mutable std::mutex requests_;  ///< between those who ask; the robot's thread never takes it
  mutable rt::CallMailbox calls_;
  bool running_ = false;  ///< guarded by requests_
  std::vector<std::string> notices_;
  std::jthread thread_;
};

}  // namespace twin::robot
