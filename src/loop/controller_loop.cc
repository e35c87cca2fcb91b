#include "twin/loop/controller_loop.h"

namespace twin::loop {
namespace {

const ControllerLoopConfig& ValidatedLoop(const ControllerLoopConfig& config) {
  config.Validate();
  return config;
}

}  // namespace

ControllerLoop::ControllerLoop(const ControllerLoopConfig& config, control::Controller& controller,
                               Exchange& exchange, std::uint64_t seed)
    : controller_(controller),
      exchange_(exchange),
      depositor_(ValidatedLoop(config), controller.command_interface(), exchange, seed),
      grid_(config, seed),
      cost_(config.cost),
      cost_random_(seed, RandomStream::kControllerCost) {}

Time ControllerLoop::Start(Time now) noexcept {
  depositor_.Reset();
  return grid_.Start(now);
}

bool ControllerLoop::OnWake(Time now) noexcept {
  exchange_.states.Refresh();
  if (!exchange_.states.has_value()) return false;
  const RobotState& state = exchange_.states.value().state;
  source_time_ = grid_.OwnTime(now);
  based_on_ = state.message_id;
  controller_.Update(state, source_time_, output_);
  current_cost_ = cost_.Draw(cost_random_, grid_.wake());
  return true;
}

Time ControllerLoop::OnDone(Time now) noexcept {
  depositor_.Put(output_, source_time_, based_on_);
  return grid_.Next(now);
}

}  // namespace twin::loop
