#pragma once

#include <cstdint>

#include "twin/loop/communication_loop.h"
#include "twin/loop/controller_loop.h"

namespace twin::loop {

/// The loop with a robot whose time is its states: each is sent when the one before has been
/// answered, and is 1 ms of its time, however long that took.
///
///   T_hat = (message_id(i) - message_id(i-1)) 1 ms
///
/// Read a state -> every wake-up of the controller that was due before the state's time, with the
/// state before it -> publish -> one that is due at it -> tick -> write, one after the other:
/// nothing depends on how fast anything is, and the same motion gives the same commands. The
/// controller has its own rate, as in the asynchronous loop, and wakes in lost cycles as it does
/// there; its time counts from the motion's first state.
///
/// Threads: one. Real-time: as CommunicationLoop.
class StateTimeLoop final : public CommunicationLoop {
 public:
  /// @param tick  that answers every state: what is not answered, such a robot waits for. Its
  ///              period_tolerance is 0.
  /// @param controller  with its delay models at zero.
  /// @param first_id, now  of the state at time zero, and of the one read last; 0: the first that
  ///              is read is at time zero.
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

  /// Of the state read last, since the one at time zero.
  [[nodiscard]] Time now() const noexcept { return now_; }
  /// Of the state at time zero; 0: none was read.
  [[nodiscard]] std::uint64_t first_id() const noexcept { return first_id_; }

 private:
  [[nodiscard]] Time ReadAt(const RobotState& state, Time arrival) noexcept TWIN_REALTIME override;
  [[nodiscard]] const RobotCommand* Compute(const RobotState& state, Time read,
                                            Duration& cost) noexcept TWIN_REALTIME override;
  void Begin(const RobotState& state) noexcept TWIN_REALTIME;
  /// @returns of a state, since the motion's first one.
  [[nodiscard]] Time TimeOf(const RobotState& state) const noexcept TWIN_REALTIME;
  /// All of the controller's wake-ups that are due by then, each at its own time.
  void WakeUntil(Time end) noexcept TWIN_REALTIME;

  ControllerLoop& controller_;
  std::uint64_t first_id_;       ///< of all; 0 before
  std::uint64_t motion_id_ = 0;  ///< first of the motion
  Time now_;
  Time wake_{};  ///< the controller's next, since the motion's first state
  bool moving_ = false;
  bool stopped_ = false;
};

}  // namespace twin::loop
