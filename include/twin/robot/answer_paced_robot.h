#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "twin/robot/threaded_robot.h"
#include "twin/rt/signal.h"

namespace twin::robot {

/// Options of a lockstep robot whose workstation is remote.
struct LockstepOptions {
  /// How long a motion waits for an answer before it is stopped, as after a disconnect.
  Duration answer_timeout = std::chrono::seconds(10);
  /// Time stops while the robot is inactive; see AnswerPacedRobot.
  bool freeze_when_idle = false;
  /// Robot time over wall-clock time, at most, in [0.01, 100]; absent: a motion is as fast as its
  /// answers.
  std::optional<double> pace{};
};

/// An emulated robot on the virtual clock, paced by a workstation behind a WorkstationPort: the
/// next cycle runs when the last state has been answered.
///
///     idle, or before a motion's       a cycle every 1 ms of the wall clock (no one answers there:
///     first command                    clients need two states of a motion before they command)
///     from the first command on,       state k -> wait for a command that answers k -> cycle k+1
///     until a state is idle again
///     stopping, after a reflex,        a cycle every 1 ms of the wall clock
///     asynchronous motion of an FR3
///
/// With a pace p, no cycle begins before its time on the wall clock, one every 1 / p ms, motion or
/// not. Delays of up to 100 ms, of the host or of answers, are made up for: programs that pace
/// themselves by the wall clock find the robot where they expect it. Longer ones move the times of
/// all further cycles.
///
/// From its first command on, a motion's states are independent of the wall clock: a command counts
/// as received at the time of the state it answers. Commands that answer any other state, or a
/// state answered before, are ignored. A motion without an answer for answer_timeout is stopped. An
/// unanswered state is sent again every 100 ms in case it was lost. Delays and losses of the
/// configured link happen on the virtual clock; the robot does not wait for an answer to a state
/// that this link loses.
///
/// freeze_when_idle: while the robot is inactive, only the last state is sent again each ms with
/// message_id + 1: no cycle, no step of the plant, no random number. So ids of motions differ
/// between two runs of a program, and nothing else does. The robot is active during a motion from
/// its first command on, a stop, motion of the reference, a command of the hand, and in every mode
/// but Idle, Move and Reflex. A request that INT grants while time stands still takes effect in one
/// cycle that runs before the reply, so a session has the same cycles whenever its requests arrive.
/// Times of the plant's disturbances and of the panel's events freeze too. A motion without a first
/// command is stopped after answer_timeout; until then the state that shows it is sent again after
/// 10 ms (clients wait for two) and then only every 500 ms, so that no state and first command
/// cross on the wire.
///
/// Pause() lets time stand still, in a motion too: no cycle, and no motion is stopped for want of
/// an answer. Clients go on receiving states: in a motion the last one each 100 ms, else as with
/// freeze_when_idle. What INT grants meanwhile shows in the next cycle. Step() lets cycles run and
/// pauses again; in a motion each of them waits for its answer as ever.
///
/// INT, the link's random numbers and the cycle records count cycles. So a record's message_id is
/// lower than that of the state the workstation received, by the number of states sent again.
///
/// Threads: as ThreadedRobot. Real-time: the thread allocates and locks nothing between Begin() and
/// End(), but it waits, and its sink may wait.
class AnswerPacedRobot final : public ThreadedRobot {
 public:
  /// As ThreadedRobot. @param commands  signalled when port.Receive() has a command; must outlive
  /// the robot.
  AnswerPacedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                   WorkstationPort& port, rt::Arrival& commands, const MonotonicClock& clock,
                   rt::ThreadSettings thread, record::RecordSink* sink,
                   const LockstepOptions& options);
  ~AnswerPacedRobot() override { End(); }

  [[nodiscard]] bool is_answer_paced() const noexcept override { return true; }

  /// Lets time stand still from the next request to the robot's thread on, which report() is.
  /// Threads: any, as the next three.
  void Pause() noexcept { cycles_allowed_.store(0, std::memory_order_relaxed); }
  void Resume() noexcept { cycles_allowed_.store(kUnlimited, std::memory_order_relaxed); }
  /// Lets `cycles` more pass. @returns false, without effect, unless time stands still.
  [[nodiscard]] bool Step(std::uint64_t cycles) noexcept;
  /// Cycles left of Step(); 0: time stands still; absent: it runs.
  [[nodiscard]] std::optional<std::uint64_t> cycles_left() const noexcept;

  /// Begins anew with the arm at rest at `q`, as Robot::Reset().
  /// @param q  rad; absent: where the configuration has it. @returns false, without effect, in a
  /// motion and while the hand executes a command. Threads: any. Allocates.
  /// @throws InputError for a joint beyond its limits; RobotFault as all requests.
  [[nodiscard]] bool Reset(const std::optional<JointVector>& q);

  /// Most snapshots at once; each holds a few MB.
  static constexpr std::size_t kMostSnapshots = 16;

  /// Keeps a copy of the whole twin: plant, hand, base, INT, both directions of the link and the
  /// time. One of the same name is replaced. Threads, errors: as Reset().
  /// @returns false, without effect, in a motion and while the hand executes a command.
  /// @throws InputError before Begin(), and beyond kMostSnapshots.
  [[nodiscard]] bool Save(const std::string& name);
  /// Goes back to a snapshot, as Robot::Restore(): from then on the same requests and commands give
  /// the same states as after Save(), each time. The workstation receives the snapshot's state, and
  /// ids that go on rising. @returns as Save(). @throws InputError for an unknown name.
  [[nodiscard]] bool Restore(const std::string& name);

  /// Number of motions stopped for want of an answer. Any thread.
  [[nodiscard]] std::uint64_t motions_given_up() const noexcept {
    return motions_given_up_.load(std::memory_order_relaxed);  // a count, orders nothing
  }

 private:
  /// The answer that a motion waits for.
  enum class Phase : std::uint8_t {
    kNone,      ///< no motion
    kStarting,  ///< none: no command yet
    kAnswered,  ///< one to every state
    kStopping,  ///< none
    kFree,      ///< none: an asynchronous motion
  };

  void OnEvent(Time now, std::uint64_t message_id) noexcept override;
  void Run(const std::stop_token& stop) noexcept override;
  void OnGranted(Granted what) noexcept override;

  /// Runs a cycle, or sends the last state again.
  void Next() noexcept;
  /// In a motion that has begun: no state may be sent that asks for another answer.
  [[nodiscard]] bool WaitsForAnswers() const noexcept {
    return phase_ == Phase::kAnswered || phase_ == Phase::kStopping;
  }
  /// Advances virtual time until the next state has arrived, or until a cycle whose state is lost
  /// has ended.
  void Advance() noexcept TWIN_REALTIME;
  /// The same, but skips states that the link loses.
  void AdvanceToState() noexcept TWIN_REALTIME;
  /// Sends the last state again, with the next id.
  void Repeat() noexcept TWIN_REALTIME;
  [[nodiscard]] bool IsFrozen() const noexcept;
  [[nodiscard]] bool is_paused() const noexcept {
    return cycles_allowed_.load(std::memory_order_relaxed) == 0;
  }
  /// Counts a cycle of Step().
  void CountDown() noexcept;
  void TakeCommands() noexcept TWIN_REALTIME;
  [[nodiscard]] Time NextCycle(Time now) const noexcept;
  /// Waits until the next cycle is due and serves requests meanwhile.
  void AwaitCycle(const std::stop_token& stop) noexcept;
  /// @returns whether the next cycle is due.
  [[nodiscard]] bool IsDue(Time now) const noexcept;
  void GiveUpIfUnanswered(Time now) noexcept TWIN_REALTIME;
  /// Stops waiting for an answer.
  void Stop() noexcept TWIN_REALTIME;

  struct Snapshot {
    rt::EventQueue events;
    Robot::Snapshot robot;
    bool owes_cycle;
  };

  static constexpr std::uint64_t kUnlimited = ~std::uint64_t{0};

  rt::Arrival& commands_;
  const LockstepOptions options_;
  /// 0: paused. A number that orders no other memory: relaxed.
  std::atomic<std::uint64_t> cycles_allowed_{kUnlimited};

  bool cycling_ = false;  ///< set by the robot's thread between Begin() and End()
  Phase phase_ = Phase::kNone;
  RobotState shown_;               ///< the state sent last
  std::uint64_t shown_cycle_ = 0;  ///< its id in INT
  std::uint64_t repeats_ = 0;      ///< states sent again: offset of ids from INT's
  bool answered_ = false;          ///< the state in shown_
  bool owes_cycle_ = false;        ///< of a request granted during a pause
  bool delivered_ = false;         ///< the last Advance() delivered a state
  ReceivedCommand received_;

  const Duration period_;  ///< of cycles that the wall clock paces
  Time next_cycle_{};      ///< on the wall clock, while that sets the pace
  Time waiting_since_{};   ///< start of the wait for an answer
  Time resend_{};
  std::mutex keeping_;  ///< guards snapshots_; the robot's thread never locks it
  std::map<std::string, Snapshot> snapshots_;
  std::atomic<std::uint64_t> motions_given_up_{0};
};

}  // namespace twin::robot
