#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/robot/workstation_port.h"
#include "twin/rt/arrival.h"
#include "twin/rt/latest_value.h"
#include "twin/rt/signal.h"
#include "twin/rt/spsc_ring.h"

namespace twin::robot {

/// The workstation in the same process, on threads of its own.
///
///     Write() ---> ring of {command, when} ---> Receive()
///     Read()  <--- LatestValue + Signal    <--- Deliver()
///
/// Threads: Write() and Read() from one (the tick's), or one each; the robot's end from the
/// robot's. Real-time: all calls are noexcept, lock nothing, allocate nothing.
class InProcessPort : public WorkstationPort {
 public:
  /// @param clock  of the run; must outlive the port.
  explicit InProcessPort(const MonotonicClock& clock) : clock_(clock), arrival_(clock) {}

  /// Puts a command on the way, as of now. When the robot's thread has left kCommands waiting, it
  /// is lost, as on the wire.
  void Write(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The newest state that has arrived since the last call, or null; valid until the next call.
  [[nodiscard]] const RobotState* Read() noexcept TWIN_REALTIME {
    return states_.Refresh() ? &states_.value() : nullptr;
  }
  /// Where to wait for the next state.
  [[nodiscard]] rt::Arrival& arrival() noexcept { return arrival_; }

  /// Commands lost because the ring was full. Any thread.
  [[nodiscard]] std::uint64_t commands_lost() const noexcept {
    return commands_lost_.load(std::memory_order_relaxed);  // a count, nothing hangs on it
  }

  [[nodiscard]] bool Receive(ReceivedCommand& received) noexcept TWIN_REALTIME final;
  void Deliver(const RobotState& state) noexcept TWIN_REALTIME final;

 private:
  /// Commands that may wait for the robot's thread: one a cycle, with room for a stall.
  static constexpr std::size_t kCommands = 64;

  const MonotonicClock& clock_;
  rt::SpscRing<ReceivedCommand> commands_{kCommands};
  std::atomic<std::uint64_t> commands_lost_{0};
  rt::LatestValue<RobotState> states_;
  rt::Signal arrival_;
};

}  // namespace twin::robot
