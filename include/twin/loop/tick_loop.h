#pragma once

#include <cstdint>

#include "twin/backend/backend.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/loop/control_tick.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/delay_model.h"

namespace twin::loop {

/// The asynchronous loop as a state machine that any drive can run: a state arrives -> tick ->
/// after its cost the command is written. In lockstep the cost is drawn and the drive calls OnDone
/// at its end; on a thread the cost is what passes.
///
///     idle --OnState--> computing --OnDone--> idle
///
/// A state that arrives while the loop is computing is not looked at (reads are *fresh*).
///
/// Threads: the tick's. Real-time: noexcept, allocates nothing.
class TickLoop {
 public:
  /// @param sink  of the tick records; may be null. @param seed  of the costs.
  TickLoop(ControlTick& tick, backend::Backend& backend, const rt::DelayModel& cost,
           std::uint64_t seed, rt::RecordSink* sink)
      : tick_(tick),
        backend_(backend),
        cost_(cost),
        random_(seed, RandomStream::kTickCost),
        sink_(sink) {}

  /// Reads the state that has arrived and computes.
  /// @returns true when OnDone is due after cost().
  [[nodiscard]] bool OnState() noexcept TWIN_REALTIME;

  /// Writes the command. @param now  end of the write.
  void OnDone(Time now) noexcept TWIN_REALTIME;

  /// Cost of the tick that is being computed.
  [[nodiscard]] Duration cost() const noexcept { return current_cost_; }

  /// The state read last; message_id 0 before the first.
  [[nodiscard]] const RobotState& state() const noexcept { return state_; }

  [[nodiscard]] std::uint64_t written() const noexcept { return written_; }
  [[nodiscard]] std::uint64_t skipped_states() const noexcept { return skipped_; }

 private:
  ControlTick& tick_;
  backend::Backend& backend_;
  rt::DelayModel cost_;
  Random random_;
  rt::RecordSink* sink_;

  bool computing_ = false;
  const RobotCommand* command_ = nullptr;
  Duration current_cost_{};
  RobotState state_;
  std::uint64_t written_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace twin::loop
