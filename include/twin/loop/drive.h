#pragma once

#include <functional>
#include <memory>
#include <string>

#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"
#include "twin/loop/shared_time.h"
#include "twin/record/cycle_record.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// Advances the time of a connected robot and runs motions.
///
///     Begin() -> { Run() | PassUntil() } ... -> End()
///
/// - Lockstep: an event queue on a virtual clock, one thread. Inputs and seed determine the
///   records. Time does not advance between calls.
/// - Realtime: the wall clock. Communication loop and controller run on threads of their own. So
///   does a simulated robot, from Begin() to End(); a remote robot has its own clock.
/// - State time: a robot served in lockstep. Each state advances time by 1 ms per message_id.
///
/// Threads: one, the caller's.
class Drive {
 public:
  virtual ~Drive() = default;
  Drive() = default;
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;

  [[nodiscard]] virtual const backend::Connection& connection() const noexcept = 0;
  /// The wall clock of realtime and state time; null in lockstep.
  [[nodiscard]] virtual const MonotonicClock* wall_clock() const noexcept { return nullptr; }

  /// Starts time. Call once.
  virtual void Begin() {}

  /// Runs a motion from start to end; `run.backend` is the connection's.
  /// @throws InputError from the controller's activation, or for a loop that the drive does not
  /// support; RobotFault when the robot refuses the motion; EnvironmentError when a thread cannot
  /// be set up. The failure of a motion that has started is reported, not thrown.
  [[nodiscard]] virtual RunReport Run(const MotionRun& run) = 0;

  /// A copy of time, of the robot and of every message under way.
  class Snapshot {
   public:
    Snapshot() = default;
    virtual ~Snapshot() = default;
    Snapshot(const Snapshot&) = delete;
    Snapshot& operator=(const Snapshot&) = delete;
  };
  /// Lockstep, between two runs: the same calls then give the same bits as after Save(), each time.
  /// @throws InputError on other drives: a clock and a real robot do not go back.
  [[nodiscard]] virtual std::unique_ptr<const Snapshot> Save() const;
  /// @pre `snapshot` is of this drive. @throws as Save().
  virtual void Restore(const Snapshot& snapshot);

  /// Stops time; after return the sink receives no record. Idempotent.
  virtual backend::RobotTimings End() { return {}; }

  /// Time since Begin().
  [[nodiscard]] virtual Time Now() const = 0;

  /// Lets time pass without a motion and reads arriving states.
  /// @param done  called often, with the state read since the last call, or null; true ends the
  /// wait.
  /// @returns false when `limit` has passed first. @throws RobotFault when the connection is lost,
  /// or no state arrives for 1 s.
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool(const RobotState*)>& done);

 private:
  /// Waits until a state may have arrived, at most until `limit`.
  virtual void Wait(Time limit) = 0;
  /// Called by PassUntil() after each read of a state.
  virtual void Observe(const RobotState& /*state*/) {}

  RobotState state_;
};

/// Threads of the realtime drive.
struct DriveThreads {
  /// Runs the simulated robot.
  rt::ThreadSettings robot{.name = "twin-int", .fifo_priority = 98};
  /// Reads states and writes commands; with the inline loops it also runs the controller.
  rt::ThreadSettings communication{.name = "twin-ext", .fifo_priority = 99};
  /// Runs the controller of the asynchronous loop.
  rt::ThreadSettings controller{.name = "twin-control"};
  /// Of a simulated robot among several on one thread, which has settings of its own; null: the
  /// robot is alone. Must outlive the drive, whose Begin() and End() wait for the other robots.
  SharedTime::Seat* seat = nullptr;
};

/// @param connect  makes the backend, from `robot`. @param sink  receives the records of cycles and
/// ticks; may be null; must outlive the drive. In lockstep, the calling thread puts all records; in
/// real time, the robot's thread puts cycles and the communication thread puts ticks.
/// @throws as `connect`.
[[nodiscard]] std::unique_ptr<Drive> MakeLockstepDrive(const backend::Factory& connect,
                                                       const robot::RobotConfig& robot,
                                                       record::RecordSink* sink);
[[nodiscard]] std::unique_ptr<Drive> MakeRealtimeDrive(const backend::Factory& connect,
                                                       const robot::RobotConfig& robot,
                                                       record::RecordSink* sink,
                                                       const DriveThreads& threads);
/// Makes a realtime or state time drive, as the connection's time selects. The sink also receives
/// the states that are read.
[[nodiscard]] std::unique_ptr<Drive> MakeRemoteDrive(const backend::Factory& connect,
                                                     const robot::RobotConfig& robot,
                                                     record::RecordSink* sink,
                                                     const backend::RobotAddress& address,
                                                     const DriveThreads& threads);

/// The state time drive: the robot's states are its time. The caller's thread reads, computes and
/// writes. It waits for states without limit, as the robot waits for commands; meanwhile no
/// time passes. A motion from the same state gives the same commands on any machine, and the same
/// log except for the number of states before the motion.
///
/// Run() throws InputError for the synchronous loop, which sleeps on a clock of its own. The drive
/// answers every state, regardless of TickConfig::period_tolerance; the robot would wait otherwise.
/// @param clock  of the connection.
[[nodiscard]] std::unique_ptr<Drive> MakeStateTimeDrive(std::unique_ptr<MonotonicClock> clock,
                                                        backend::Connection connection);

}  // namespace twin::loop
