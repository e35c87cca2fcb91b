#pragma once

#include "twin/loop/communication_loop.h"

namespace twin::loop {

/// The paper's asynchronous loop: block on a fresh state -> publish -> fetch the newest deposit ->
/// transmit. Controllers run beside it, in a ControllerLoop.
/// Source: the paper's section on the asynchronous thread.
class AsynchronousLoop final : public CommunicationLoop {
 public:
  /// @param cost, seed  lockstep: model and seed of the time from read to write.
  AsynchronousLoop(ControlTick& tick, backend::Backend& backend, const faults::DelayModel& cost,
                   std::uint64_t seed, record::RecordSink* sink)
      : CommunicationLoop(tick, backend, sink, backend::ReadRule::kFresh),
        cost_model_(cost),
        random_(seed, RandomStream::kTickCost) {}

  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME override { return now; }

 private:
  [[nodiscard]] const RobotCommand* Compute(const RobotState& state, Time read,
                                            Duration& cost) noexcept TWIN_REALTIME override {
    cost = cost_model_.Draw(random_, state.message_id);
    return tick_.Tick(state, read);
  }

  faults::DelayModel cost_model_;
  Random random_;
};

}  // namespace twin::loop
