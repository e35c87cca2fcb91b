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

/// Timing statistics of one side of the communication while commands were sent.
struct LoopTimings {
  rt::DurationHistogram d_EXT;       ///< end of the state's read to end of the command's write
  rt::DurationHistogram period;      ///< between the reads of two successive states
  std::uint64_t written = 0;         ///< commands
  std::uint64_t anomalous = 0;       ///< states not answered: anomalous period (ControlTick)
  std::uint64_t stalled = 0;         ///< commands made while the source was stalled
  std::uint64_t skipped_states = 0;  ///< states that the workstation did not receive
};

/// The workstation's side of the communication as a state machine that every drive can run: read a
/// state, compute, write a command.
///
///     reading --OnState--> computing --Write, OnDone--> sleeping until OnDone's time --> reading
///
/// In lockstep, the drive calls OnState when a state arrives, and Write and OnDone after cost(),
/// which is drawn at random. A thread waits for a state, and the computation takes its actual time.
/// The derived loop (asynchronous, synchronous or bare) determines the computation and the start of
/// the next read.
///
/// Threads: one. Real-time: all calls after construction are noexcept and allocate nothing.
class CommunicationLoop {
 public:
  /// Result of OnState().
  enum class Outcome : std::uint8_t {
    kPending,    ///< no state yet: wait and try again
    kComputing,  ///< a state was read; Write and OnDone are due after cost()
    kLost,       ///< the connection is lost
  };

  virtual ~CommunicationLoop() = default;

  /// Starts the loop, with or without a motion. @returns start of the first read.
  [[nodiscard]] virtual Time Start(Time now) noexcept TWIN_REALTIME = 0;

  /// True: the sink also gets every state, as a cycle record without the fate of its command. The
  /// record is put after the write, so it does not add to d_EXT. For robots without cycle records.
  void RecordStates(bool record) noexcept { records_states_ = record; }

  /// Reads a state, without waiting, and computes its answer.
  [[nodiscard]] Outcome OnState() noexcept TWIN_REALTIME;

  /// Writes the command, if Compute() returned one.
  void Write() noexcept TWIN_REALTIME;

  /// Ends the tick. @param now  end of the write.
  /// @returns start of the next read; a time not after `now` means at once.
  [[nodiscard]] Time OnDone(Time now) noexcept TWIN_REALTIME;

  /// Prepares a motion with these modes, before its start.
  virtual void Activate(const MotionModes& modes) noexcept { tick_.Activate(modes); }
  /// Ends this loop's updates of the controller.
  virtual void StopController() noexcept {}

  /// Time that the current computation takes by the delay models.
  [[nodiscard]] Duration cost() const noexcept { return cost_; }
  /// The state read last; message_id 0 before the first.
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }
  /// True when state() belongs to the running motion.
  [[nodiscard]] bool InMotion() const noexcept { return tick_.InMotion(state_); }
  /// True once the tick has stopped the arm before a limit of the lab.
  [[nodiscard]] bool stopped_by_limit() const noexcept { return tick_.stopped_by_limit(); }
  /// Record of the last tick.
  [[nodiscard]] const record::TickRecord& record() noexcept { return tick_.record(); }
  [[nodiscard]] const LoopTimings& timings() const noexcept { return timings_; }
  /// Deviation of the arm from its targets so far.
  [[nodiscard]] Deviation deviation() const noexcept { return deviation_.Result(); }

  /// The last ticks, oldest first: evidence of a failure. Allocates; not for the tick.
  [[nodiscard]] std::vector<record::TickRecord> LastTicks() const;

 protected:
  /// @param sink  receives the tick records; may be null.
  CommunicationLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
                    backend::ReadRule rule)
      : tick_(tick), backend_(backend), sink_(sink), rule_(rule), deviation_(tick.interface()) {}

  /// Computes the answer to `state`. @param read  end of its read.
  /// @param cost  out: time that the computation takes by the delay models.
  /// @returns the command, or null.
  [[nodiscard]] virtual const RobotCommand* Compute(const RobotState& state, Time read,
                                                    Duration& cost) noexcept TWIN_REALTIME = 0;
  /// @returns the time of a state's read on the loop's clock. @param arrival  from the backend.
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
  record::CycleRecord cycle_;  ///< the last state put into the sink
  const RobotCommand* command_ = nullptr;
  Duration cost_{};
  Time last_read_{};
  LoopTimings timings_;
  DeviationMeter deviation_;
  std::array<record::TickRecord, kKept> kept_{};
  std::size_t ticks_ = 0;
};

}  // namespace twin::loop
