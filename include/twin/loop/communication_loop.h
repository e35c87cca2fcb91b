#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/faults/delay_model.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/deviation.h"
#include "twin/record/cycle_record.h"
#include "twin/rt/duration_histogram.h"

namespace twin::loop {

/// How one side of the communication kept time while commands were sent.
struct LoopTimings {
  rt::DurationHistogram d_EXT;       ///< end of the state's read to end of the command's write
  rt::DurationHistogram period;      ///< between the reads of two successive states
  std::uint64_t written = 0;         ///< commands
  std::uint64_t anomalous = 0;       ///< states not answered because they came out of time
  std::uint64_t stalled = 0;         ///< commands made while the source counted as stalled
  std::uint64_t skipped_states = 0;  ///< states that never reached the workstation
};

/// The workstation's side of the communication as a state machine that any drive can run: read a
/// state, compute, write a command.
///
///     reading --OnState--> computing --Write, OnDone--> (sleeping until what OnDone returned)
///     reading
///
/// In lockstep the drive calls OnState when a state arrives, and Write and OnDone after cost(),
/// which is drawn; on a thread it waits for a state, and the cost is what passes. What is computed,
/// and when the next read begins, is the loop's: asynchronous, synchronous or bare.
///
/// Threads: one. Real-time: all calls after construction are noexcept and allocate nothing.
class CommunicationLoop {
 public:
  /// What came of a look for a state.
  enum class Outcome : std::uint8_t {
    kPending,    ///< none yet: wait and look again
    kComputing,  ///< a state was read; Write and OnDone are due after cost()
    kLost,       ///< the connection is gone
  };

  virtual ~CommunicationLoop() = default;

  /// The loop begins to run, motion or not. @returns when to begin the first read.
  [[nodiscard]] virtual Time Start(Time now) noexcept TWIN_REALTIME = 0;

  /// Whether the sink also gets every state, as a cycle whose command's fate is not known: after
  /// the command was written, off the way between the two. For robots that put no cycles
  /// themselves.
  void RecordStates(bool record) noexcept { records_states_ = record; }

  /// Looks for a state, and computes when there is one.
  [[nodiscard]] Outcome OnState() noexcept TWIN_REALTIME;

  /// Writes the command, if there is one.
  void Write() noexcept TWIN_REALTIME;

  /// The tick is done. @param now  after Write(): end of the write.
  /// @returns when to begin the next read; not after `now`: at once.
  [[nodiscard]] Time OnDone(Time now) noexcept TWIN_REALTIME;

  /// A motion with these modes is about to start.
  virtual void Activate(const MotionModes& modes) noexcept { tick_.Activate(modes); }
  /// No controller is updated by this loop from here on.
  virtual void StopController() noexcept {}

  /// Cost of what is being computed, as the delay models have it.
  [[nodiscard]] Duration cost() const noexcept { return cost_; }
  /// The state read last; message_id 0 before the first.
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }
  /// Whether that state belongs to the running motion.
  [[nodiscard]] bool InMotion() const noexcept { return tick_.InMotion(state_); }
  /// What the last tick did.
  [[nodiscard]] const record::TickRecord& record() noexcept { return tick_.record(); }
  [[nodiscard]] const LoopTimings& timings() const noexcept { return timings_; }
  /// Of the arm from what its commands were made for, so far.
  [[nodiscard]] Deviation deviation() const noexcept { return deviation_.Result(); }

  /// The last ticks, oldest first: the evidence when something failed. Not on the tick's path.
  [[nodiscard]] std::vector<record::TickRecord> LastTicks() const;

 protected:
  /// @param sink  of the tick records; may be null.
  CommunicationLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
                    backend::ReadRule rule)
      : tick_(tick), backend_(backend), sink_(sink), rule_(rule), deviation_(tick.interface()) {}

  /// Computes what answers `state`. @param read  when its read ended.
  /// @returns the command, or null; sets `cost` to what the delay models say it took.
  [[nodiscard]] virtual const RobotCommand* Compute(const RobotState& state, Time read,
                                                    Duration& cost) noexcept TWIN_REALTIME = 0;
  /// @returns when a state was read, on the loop's time line. @param arrival  as the backend tells.
  [[nodiscard]] virtual Time ReadAt(const RobotState& /*state*/,
                                    Time arrival) noexcept TWIN_REALTIME {
    return arrival;
  }
  /// @returns as OnDone.
  [[nodiscard]] virtual Time NextRead(Time now) noexcept TWIN_REALTIME { return now; }

  ControlTick& tick_;

 private:
  static constexpr std::size_t kKept = 32;

  void Count(const record::TickRecord& record) noexcept;
  void PutState(Time read) noexcept;

  backend::Backend& backend_;
  record::RecordSink* sink_;
  backend::ReadRule rule_;
  bool records_states_ = false;

  RobotState state_;
  record::CycleRecord cycle_;  ///< the state put last
  const RobotCommand* command_ = nullptr;
  Duration cost_{};
  Time last_read_{};
  LoopTimings timings_;
  DeviationMeter deviation_;
  std::array<record::TickRecord, kKept> kept_{};
  std::size_t ticks_ = 0;
};

}  // namespace twin::loop
