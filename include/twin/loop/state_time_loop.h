#pragma once

#include <cstdint>

#include "twin/loop/communication_loop.h"
#include "twin/loop/controller_loop.h"

namespace twin::loop {

/// The loop for a robot whose states are its time. The robot sends a state when the previous one
/// has been answered. Time advances by 1 ms per message_id, regardless of the wall clock:
///
///   T_hat = (message_id(i) - message_id(i-1)) 1 ms
///
/// A cycle runs in sequence: read a state -> the controller's wake-ups that were due before the
/// state's time, with the previous state -> publish -> the wake-up due at this time -> tick ->
/// write. No result depends on the speed of the machine: the same motion gives the same commands.
/// As in the asynchronous loop, the controller has its own rate and also wakes in lost cycles. Its
/// time counts from the motion's first state.
///
/// Threads: one. Real-time: as CommunicationLoop.
class StateTimeLoop final : public CommunicationLoop {
 public:
  /// @param tick  must answer every state, because the robot waits for the answer:
  ///              period_tolerance 0.
  /// @param controller  with delay models of zero.
  /// @param first_id  message_id of the state at time zero; 0: the first state read.
  /// @param now  time of the state read last.
  StateTimeLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
                ControllerLoop& controller, std::uint64_t first_id = 0, Time now = {})
      : CommunicationLoop(tick, backend, sink, backend::ReadRule::kNewest),
        controller_(controller),
        first_id_(first_id),
        now_(now) {}

  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME override { return now; }
  void Activate(const MotionModes& modes) noexcept override {
    CommunicationLoop::Activate(modes);
    moving_ = false;
    stopped_ = false;
  }
  void StopController() noexcept override { stopped_ = true; }

  /// Time of the state read last, since the state at time zero.
  [[nodiscard]] Time now() const noexcept { return now_; }
  /// message_id of the state at time zero; 0: none was read.
  [[nodiscard]] std::uint64_t first_id() const noexcept { return first_id_; }

 private:
  [[nodiscard]] Time ReadAt(const RobotState& state, Time arrival) noexcept TWIN_REALTIME override;
  [[nodiscard]] const RobotCommand* Compute(const RobotState& state, Time read,
                                            Duration& cost) noexcept TWIN_REALTIME override;
  void Begin(const RobotState& state) noexcept TWIN_REALTIME;
  /// @returns time of a state since the motion's first state.
  [[nodiscard]] Time TimeOf(const RobotState& state) const noexcept TWIN_REALTIME;
  /// Runs all of the controller's wake-ups due until `end`, each at its own time.
  void WakeUntil(Time end) noexcept TWIN_REALTIME;

  ControllerLoop& controller_;
  std::uint64_t first_id_;       ///< message_id of the state at time zero; 0 before
  std::uint64_t motion_id_ = 0;  ///< message_id of the motion's first state
  Time now_;
  Time wake_{};  ///< the controller's next wake-up, since the motion's first state
  bool moving_ = false;
  bool stopped_ = false;
};

}  // namespace twin::loop
