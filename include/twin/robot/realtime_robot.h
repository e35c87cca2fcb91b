#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/robot/wall_clock_robot.h"
#include "twin/robot/workstation_port.h"
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

/// The emulated robot on the wall clock with its workstation in the same process: both ends of the
/// link in one object.
///
/// Threads and real-time: as InProcessPort and WallClockRobot.
class RealtimeRobot final : public InProcessPort, public WallClockRobot {
 public:
  /// @param clock   of the run; must outlive the robot.
  /// @param thread  setup of the robot's thread.
  /// @param plant, sink  as in Robot; the robot's thread puts sink's cycle records.
  /// @throws InputError as Robot.
  RealtimeRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                const MonotonicClock& clock, rt::ThreadSettings thread, record::RecordSink* sink)
      : InProcessPort(clock),
        WallClockRobot(config, std::move(plant), *this, clock, std::move(thread), sink) {}
  /// Ends the thread before any member is destroyed.
  ~RealtimeRobot() override { End(); }
};

}  // namespace twin::robot
