#include "twin/loop/inline_loops.h"

namespace twin::loop {

InlineLoop::InlineLoop(ControlTick& tick, backend::Backend& backend, record::RecordSink* sink,
                       backend::ReadRule rule, control::Controller& controller, Exchange& exchange,
                       const TickConfig& tick_config, const ControllerLoopConfig& config,
                       std::uint64_t seed)
    : CommunicationLoop(tick, backend, sink, rule),
      controller_(controller),
      depositor_(config, controller.command_interface(), exchange, seed),
      tick_cost_(tick_config.cost),
      controller_cost_(config.cost),
      tick_random_(seed, RandomStream::kTickCost),
      controller_random_(seed, RandomStream::kControllerCost) {}

void InlineLoop::Activate(const MotionModes& modes) noexcept {
  CommunicationLoop::Activate(modes);
  depositor_.Reset();
  stopped_ = false;
}

const RobotCommand* InlineLoop::Compute(const RobotState& state, Time read,
                                        Duration& cost) noexcept {
  tick_.Publish(state, read);
  cost = tick_cost_.Draw(tick_random_, state.message_id);
  if (tick_.InMotion(state) && !stopped_) {
    const Time now = ControllerTime(state, read);
    controller_.Update(state, now, output_);
    depositor_.Put(output_, now, state.message_id);
    cost += controller_cost_.Draw(controller_random_, state.message_id);
  }
  return tick_.Answer(state);
}

}  // namespace twin::loop
