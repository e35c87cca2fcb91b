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

/// Port to a workstation in the same process, on its own threads.
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

  /// Sends a command at the present time. It is lost, as on the wire, when kCommands are waiting
  /// for the robot's thread.
  void Write(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The newest state since the last call, or null; valid until the next call.
  [[nodiscard]] const RobotState* Read() noexcept TWIN_REALTIME {
    return states_.Refresh() ? &states_.value() : nullptr;
  }
  /// Signalled when a state arrives.
  [[nodiscard]] rt::Arrival& arrival() noexcept { return arrival_; }

  /// Commands lost because the ring was full. Any thread.
  [[nodiscard]] std::uint64_t commands_lost() const noexcept {
    return commands_lost_.load(std::memory_order_relaxed);  // a count, orders nothing
  }

  [[nodiscard]] bool Receive(ReceivedCommand& received) noexcept TWIN_REALTIME final;
  void Deliver(const RobotState& state) noexcept TWIN_REALTIME final;

 private:
  /// Capacity for waiting commands: one per cycle, with room for a stall.
  static constexpr std::size_t kCommands = 64;

  const MonotonicClock& clock_;
  rt::SpscRing<ReceivedCommand> commands_{kCommands};
  std::atomic<std::uint64_t> commands_lost_{0};
  rt::LatestValue<RobotState> states_;
  rt::Signal arrival_;
};

}  // namespace twin::robot
