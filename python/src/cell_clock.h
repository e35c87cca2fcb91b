#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "twin/core/time.h"
#include "twin/record/cycle_record.h"

namespace twin::python {

/// Ends a function of Cell.together() after another one has failed. In Python a BaseException,
/// which no handler of errors takes for one.
class Cancelled : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override {
    return "the function of another robot has failed, or a signal has stopped all";
  }
};

/// One robot of a cell, as its clock knows it.
struct CellMember {
  std::string name;
  std::size_t island = 0;  ///< robots with the same number share a model
};

/// The one time of a cell's robots, each of which has an event queue of its own.
///
/// A call of a robot passes time: at the end of each of its cycles it waits until every other robot
/// has had as many; those that share its model it meets in the step. A robot in no call is led: its
/// next cycle runs on the waiting thread, where INT holds the arm. So between two calls all robots
/// have had the same number of cycles.
///
/// Several functions at once (Gather) each have a thread, of which one runs at a time; it hands
/// over, in the order of the functions, where its robot waits for one that another thread has:
///
///     thread 0   Enter, cycle 1 .               . cycle 2 .               . Leave
///     thread 1                  ` Enter, cycle 1           ` cycle 2, Leave
///
/// What the robots do depends on that order alone. No function's robot is led before the function
/// has begun: all begin at one instant.
///
/// Threads: any, but calls of a robot only from one at a time, or from the one whose turn it is
/// (checked by Call). Threads that wait must not hold the GIL.
class CellClock {
 public:
  /// @param members  in the order in which they are led, and named by their index from here on.
  explicit CellClock(std::vector<CellMember> members);

  /// @param lead  lets a robot's time pass until cycles() of it has grown. Before the first call.
  void SetLead(std::size_t robot, std::function<void()> lead) {
    robots_[robot].lead = std::move(lead);
  }
  /// Cycles that a robot has had.
  [[nodiscard]] std::uint64_t cycles(std::size_t robot) const noexcept {
    return robots_[robot].cycles;
  }
  /// Time that has passed for all robots. @throws as Call.
  [[nodiscard]] Duration Now() const;

  /// While it lives, a robot is in a call of this thread.
  class Call {
   public:
    /// @throws std::runtime_error while another thread or call has the robot or the cell; Cancelled
    /// in a function, after Cancel().
    Call(CellClock& clock, std::size_t robot) : clock_(clock), robot_(robot) { clock.Admit(robot); }
    ~Call() { clock_.Dismount(robot_); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    CellClock& clock_;
    const std::size_t robot_;
  };

  // By a robot in a call, or one that is led.

  /// A robot has had a cycle. Returns when it may go on.
  void EndCycle(std::size_t robot) noexcept;
  /// A robot waits for the step of its island's model: plant::SharedModel's `others`.
  void LetOthers(std::size_t island) noexcept;

  // Several functions at once.

  /// Announces functions, each of a robot of its own. @throws std::runtime_error while a call or
  /// other functions are under way.
  void Gather(const std::vector<std::size_t>& robots);
  /// On a function's thread: returns when its turn has come. @throws Cancelled then, after
  /// Cancel(), and when the function has left.
  void Enter(std::size_t function);
  /// The function whose turn it is has ended, or will not begin. Does nothing when it has left.
  void Leave(std::size_t function) noexcept;
  /// @returns whether all functions have left, after which calls are as before Gather().
  [[nodiscard]] bool AwaitEnd(std::chrono::milliseconds limit);
  /// The next call of each function throws Cancelled.
  void Cancel() noexcept { cancelled_ = true; }
  /// As Cancel(), and calls under way shall stop: they look at is_stopping().
  void Stop() noexcept {
    stopping_ = true;
    cancelled_ = true;
  }
  [[nodiscard]] bool is_stopping() const noexcept { return stopping_; }

  /// @throws std::runtime_error while a call or functions are under way.
  void RequireIdle() const;

 private:
  struct Robot {
    CellMember member;
    std::function<void()> lead{};
    std::uint64_t cycles = 0;
    std::optional<std::size_t> caller{};  ///< function whose call it is in; 0: without functions
    bool is_led = false;
    bool awaits_function = false;

    [[nodiscard]] bool is_taken() const noexcept { return caller || is_led || awaits_function; }
  };
  struct Function {
    std::size_t robot = 0;
    std::thread::id thread{};
    bool has_left = false;
  };

  /// Whether this thread may make a call: it has none under way, and the turn.
  [[nodiscard]] bool MayCall() const;
  void Admit(std::size_t robot);
  void Dismount(std::size_t robot) noexcept;
  void Lead(Robot& robot) noexcept;
  /// Lets the other threads go on until it is this one's turn again. @pre another function.
  void HandOver() noexcept;
  /// The function after one that has not left; itself when it is the only one.
  [[nodiscard]] std::size_t After(std::size_t function) const noexcept;
  [[nodiscard]] bool has_call() const noexcept;

  mutable std::mutex mutex_;  ///< of all below; between calls of others' threads, of the turn too
  std::condition_variable turned_;
  std::condition_variable ended_;  ///< a function has left
  std::vector<Robot> robots_;      ///< of the thread whose turn it is
  std::vector<Function> functions_;
  std::size_t turn_ = 0;  ///< index in functions_
  // Set by any thread, read by the calls; each stands for itself, so the order does not count.
  std::atomic<bool> cancelled_{false};
  std::atomic<bool> stopping_{false};
};

/// Tells the clock of a robot's cycles, once their records are where they belong.
class CycleEnds final : public record::RecordSink {
 public:
  /// @param next  may be null.
  CycleEnds(CellClock& clock, std::size_t robot, record::RecordSink* next)
      : clock_(clock), robot_(robot), next_(next) {}

  void Put(const record::CycleRecord& record) noexcept override {
    if (next_ != nullptr) next_->Put(record);
    clock_.EndCycle(robot_);
  }
  void Put(const record::TickRecord& record) noexcept override {
    if (next_ != nullptr) next_->Put(record);
  }

 private:
  CellClock& clock_;
  const std::size_t robot_;
  record::RecordSink* const next_;
};

}  // namespace twin::python
