#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "twin/robot/threaded_robot.h"
#include "twin/rt/arrival.h"

namespace twin::robot {

/// How a robot in lockstep treats a workstation that it cannot see.
struct LockstepOptions {
  /// For how long a motion waits for an answer before it is stopped, as if the workstation had
  /// gone.
  Duration answer_timeout = std::chrono::seconds(10);
  /// Time stands still while nothing is under way; see AnswerPacedRobot.
  bool freeze_when_idle = false;
};

/// A whole emulated robot on the virtual clock, paced by a workstation beyond a WorkstationPort:
/// the next cycle runs when the last state has been answered.
///
///     idle, or before a motion's       a cycle every 1 ms of the wall clock (no one answers there:
///     first command                    clients need two states of a motion before they command)
///     from the first command on,       state k -> wait for a command that answers k -> cycle k+1
///     until a state is idle again
///     stopping, after a reflex         a cycle every 1 ms of the wall clock
///
/// Nothing of the wall clock enters a motion from its first command on: a command counts as having
/// come at the instant of the state it answers, whatever it took; what answers another state than
/// the last one, or one that has been answered, is ignored. A motion that waits for longer than
/// answer_timeout is stopped. A state that is not answered is sent again every 100 ms, for the case
/// that it was lost. What the configured link delays or loses happens on the virtual clock; a state
/// it lost is not waited for.
///
/// freeze_when_idle: while nothing is under way, the last state is sent again each ms with
/// message_id + 1, and nothing else happens: no cycle, no step of the plant, no random number; so
/// ids of motions differ between two runs of a program, and nothing else does. Under way are: a
/// motion from its first command on, a stop, a reference that still moves, a command of the hand,
/// and every mode but Idle, Move and Reflex. A request that INT grants while time stands still
/// takes effect in one cycle that runs at once, before it is answered: a session has the same
/// cycles whenever its requests come. Time of the plant's disturbances and of the panel's events
/// stands still too. A motion without a first command is stopped after answer_timeout; until then
/// the state that shows it is sent again after 10 ms (clients want to see two) and then only every
/// 500 ms, so that no state and first command cross each other on their way.
///
/// INT, the link's random numbers and the records of cycles count cycles, so the message_id in a
/// record is lower than that in the state the workstation saw by the states that were sent again.
///
/// Threads: as ThreadedRobot. Real-time: the thread allocates and locks nothing between Begin() and
/// End(), but it waits, and its sink may.
class AnswerPacedRobot final : public ThreadedRobot {
 public:
  /// As ThreadedRobot. @param commands  where to wait for what port.Receive() gives; must outlive
  /// the robot.
  AnswerPacedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                   WorkstationPort& port, rt::Arrival& commands, const MonotonicClock& clock,
                   rt::ThreadSettings thread, rt::RecordSink* sink, const LockstepOptions& options);
  ~AnswerPacedRobot() override { End(); }

  /// Motions that were stopped because they were not answered. Any thread.
  [[nodiscard]] std::uint64_t motions_given_up() const noexcept {
    return motions_given_up_.load(std::memory_order_relaxed);  // a count, nothing hangs on it
  }

 private:
  /// What a motion waits for.
  enum class Phase : std::uint8_t {
    kNone,      ///< no motion
    kStarting,  ///< nothing: no command has come yet
    kAnswered,  ///< an answer to every state
    kStopping,  ///< nothing
  };

  void OnEvent(Time now, std::uint64_t message_id) noexcept override;
  void Run(const std::stop_token& stop) noexcept override;
  void OnGranted(Granted what) noexcept override;

  /// Lets virtual time go on until the next state has come through, or a cycle whose state is lost
  /// is over.
  void Advance() noexcept TWIN_REALTIME;
  /// The same, past states that the link loses.
  void AdvanceToState() noexcept TWIN_REALTIME;
  /// Sends the last state again, as the next.
  void Repeat() noexcept TWIN_REALTIME;
  [[nodiscard]] bool IsFrozen() const noexcept;
  void TakeCommands() noexcept TWIN_REALTIME;
  /// Waits until the next cycle is due, and does meanwhile what is asked.
  void AwaitCycle(const std::stop_token& stop) noexcept;
  /// @returns whether the next cycle is due.
  [[nodiscard]] bool IsDue(Time now) const noexcept;
  void GiveUpIfUnanswered(Time now) noexcept TWIN_REALTIME;
  /// Nothing is waited for any more.
  void Stop() noexcept TWIN_REALTIME;

  rt::Arrival& commands_;
  const LockstepOptions options_;

  bool cycling_ = false;  ///< on the robot's thread, between Begin() and End()
  Phase phase_ = Phase::kNone;
  RobotState shown_;               ///< as it was sent last
  std::uint64_t shown_cycle_ = 0;  ///< INT's id of it
  std::uint64_t repeats_ = 0;      ///< states sent again so far: what ids are ahead of INT's
  bool answered_ = false;          ///< the state shown
  bool delivered_ = false;         ///< the last Advance() showed a state
  ReceivedCommand received_;

  Time next_cycle_{};     ///< on the wall clock, where it paces
  Time waiting_since_{};  ///< for an answer
  Time resend_{};
  std::atomic<std::uint64_t> motions_given_up_{0};
};

}  // namespace twin::robot
