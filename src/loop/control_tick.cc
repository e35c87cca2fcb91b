#include "twin/loop/control_tick.h"

#include <algorithm>
#include <cmath>

namespace twin::loop {
namespace {

TickConfig Validated(const TickConfig& config, control::CommandInterface interface) {
  config.Validate(interface);
  return config;
}

}  // namespace

ControlTick::ControlTick(const TickConfig& config, control::CommandInterface interface,
                         Exchange& exchange)
    : config_(Validated(config, interface)),
      interface_(interface),
      exchange_(exchange),
      matcher_(config.rate_matching ? config.source_rate_hz : 1000),
      generator_(config.lambda) {}

void ControlTick::Activate(const MotionModes& modes) noexcept {
  modes_ = modes;
  first_id_ = 0;
  open_ = false;
  finishing_ = false;
}

bool ControlTick::InMotion(const RobotState& state) const noexcept {
  return state.robot_mode == RobotMode::kMove && state.controller_mode == modes_.controller &&
         state.motion_generator_mode == modes_.generator;
}

const RobotCommand* ControlTick::Tick(const RobotState& state, Time read) noexcept {
  record_.skipped_states =
      record_.message_id == 0
          ? 0
          : static_cast<std::uint32_t>(state.message_id - record_.message_id - 1);
  record_.message_id = state.message_id;
  record_.read = read;
  record_.written = read;
  record_.action = rt::TickAction::kPublished;
  record_.command = RobotCommand();

  exchange_.states.PublishWith([&](PublishedState& published) {
    published.state = state;
    published.read = read;
  });
  exchange_.deposits.Refresh();

  if (!InMotion(state) || !PassesGate(state)) return nullptr;
  Generate(state);
  record_.action = finishing_ ? rt::TickAction::kFinished : rt::TickAction::kWritten;
  return &record_.command;
}

bool ControlTick::PassesGate(const RobotState& state) noexcept {
  if (first_id_ == 0) {
    first_id_ = state.message_id;
    return false;
  }
  if (open_) return true;
  if (!exchange_.deposits.has_value() || exchange_.deposits.value().based_on < first_id_) {
    return false;
  }
  open_ = true;
  matcher_.Reset({state.q_d, {}, {}});
  return true;
}

void ControlTick::Generate(const RobotState& state) noexcept {
  const Deposit& deposit = exchange_.deposits.value();
  // The matcher's window is of cycles: those whose states were lost on the way count too.
  const std::size_t missed = std::min<std::size_t>(record_.skipped_states, matcher_.window());
  for (std::size_t i = 0; i < missed; ++i) static_cast<void>(matcher_.Next(deposit.target));
  matched_ = matcher_.Next(deposit.target);
  RobotCommand& command = record_.command;
  command.message_id = state.message_id;
  if (interface_ == control::CommandInterface::kJointVelocity) {
    command.dq_c = matched_.dq;
  } else if (config_.generator == Generator::kJoint) {
    command.q_c = generator_.Next(state.q_d, matched_);
  } else {
    command.q_c = matched_.q;
  }
  finishing_ = finishing_ || (deposit.finished && Arrived(state));
  command.motion_generation_finished = finishing_;

  record_.deposit_time = deposit.source_time;
  record_.q_ext = matched_.q;
  record_.dq_ext = matched_.dq;
}

bool ControlTick::Arrived(const RobotState& state) const noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (matched_.dq[i] != 0) return false;
    if (interface_ == control::CommandInterface::kJointVelocity) continue;
    if (std::abs(matched_.q[i] - state.q_d[i]) > config_.finish_tolerance_rad) return false;
  }
  return true;
}

}  // namespace twin::loop
