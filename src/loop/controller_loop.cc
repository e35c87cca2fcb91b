#include "twin/loop/controller_loop.h"

namespace twin::loop {
namespace {

ControllerLoopConfig Validated(const ControllerLoopConfig& config) {
  config.Validate();
  return config;
}

}  // namespace

ControllerLoop::ControllerLoop(const ControllerLoopConfig& config, control::Controller& controller,
                               Exchange& exchange, std::uint64_t seed)
    : config_(Validated(config)),
      controller_(controller),
      exchange_(exchange),
      feed_forward_(config.feed_forward, FromSeconds(1.0 / config.rate_hz)),
      wake_random_(seed, RandomStream::kControllerWake),
      cost_random_(seed, RandomStream::kControllerCost) {}

Time ControllerLoop::Start(Time now) noexcept {
  start_ = now;
  wake_ = 0;
  overruns_ = 0;
  feed_forward_.Reset();
  return Due(0) + config_.wake_delay.Draw(wake_random_, 0);
}

Time ControllerLoop::Due(std::uint64_t wake) const noexcept {
  const double own_s = static_cast<double>(wake) / config_.rate_hz;
  return start_ + config_.phase + FromSeconds(own_s / (1 + config_.clock_ppm * 1e-6));
}

Time ControllerLoop::OwnTime(Time now) const noexcept {
  return Time(FromSeconds(ToSeconds(now.time_since_epoch()) * (1 + config_.clock_ppm * 1e-6)));
}

bool ControllerLoop::OnWake(Time now) noexcept {
  exchange_.states.Refresh();
  if (!exchange_.states.has_value()) return false;
  const RobotState& state = exchange_.states.value().state;
  deposit_.source_time = OwnTime(now);
  deposit_.based_on = state.message_id;
  controller_.Update(state, deposit_.source_time, output_);
  current_cost_ = config_.cost.Draw(cost_random_, wake_);
  return true;
}

Time ControllerLoop::OnDone(Time now) noexcept {
  const reference::JointTarget formed = feed_forward_.Next(deposit_.source_time, output_.target.q);
  deposit_.target = output_.target;
  if (!output_.has_velocity) deposit_.target.dq = formed.dq;
  deposit_.finished = output_.finished;
  exchange_.deposits.Publish(deposit_);
  return NextWake(now);
}

Time ControllerLoop::NextWake(Time now) noexcept {
  ++wake_;
  while (Due(wake_) < now) {
    ++wake_;
    ++overruns_;
  }
  return Due(wake_) + config_.wake_delay.Draw(wake_random_, wake_);
}

}  // namespace twin::loop
