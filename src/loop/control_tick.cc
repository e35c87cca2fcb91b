#include "twin/loop/control_tick.h"

namespace twin::loop {
namespace {

/// A source that has finished for more commands than this, and still moves, is noise.
constexpr std::uint64_t kSourceRests = 100;

}  // namespace

ControlTick::ControlTick(const TickConfig& config, control::CommandInterface interface,
                         Exchange& exchange)
    : interface_(interface),
      period_tolerance_(config.period_tolerance),
      exchange_(exchange),
      chain_(config, interface) {}

void ControlTick::Activate(const MotionModes& modes) noexcept {
  modes_ = modes;
  first_id_ = 0;
  open_ = false;
  finished_for_ = 0;
}

bool ControlTick::InMotion(const RobotState& state) const noexcept {
  return state.robot_mode == RobotMode::kMove && state.controller_mode == modes_.controller &&
         state.motion_generator_mode == modes_.generator;
}

const RobotCommand* ControlTick::Tick(const RobotState& state, Time read) noexcept {
  Publish(state, read);
  return Answer(state);
}

bool ControlTick::IsAnomalous(Time read) const noexcept {
  if (period_tolerance_ == Duration::zero() || record_.message_id == 0) return false;
  const Duration off = read - record_.read - kCycle;
  return off > period_tolerance_ || off < -period_tolerance_;
}

void ControlTick::Publish(const RobotState& state, Time read) noexcept {
  anomalous_ = IsAnomalous(read);
  record_.skipped_states =
      record_.message_id == 0
          ? 0
          : static_cast<std::uint32_t>(state.message_id - record_.message_id - 1);
  cycles_ += record_.skipped_states + 1;
  record_.message_id = state.message_id;
  record_.read = read;
  record_.written = read;
  record_.action = record::TickAction::kPublished;
  record_.command = RobotCommand();
  record_.margin.reset();
  record_.kept_back = 0;
  record_.stalled = false;

  exchange_.states.PublishWith([&](PublishedState& published) {
    published.state = state;
    published.read = read;
  });
}

const RobotCommand* ControlTick::Answer(const RobotState& state) noexcept {
  fresh_ = exchange_.deposits.Refresh() || fresh_;
  if (!InMotion(state) || !PassesGate(state)) return nullptr;
  if (anomalous_) {
    record_.action = record::TickAction::kSkipped;
    return nullptr;
  }
  Generate(state);
  if (exchange_.deposits.value().failed || !IsValid(record_.command, interface_)) {
    record_.action = record::TickAction::kInvalid;
    return nullptr;
  }
  if (chain_.breach()) {
    record_.action = record::TickAction::kLimited;
    if (chain_.sends()) return &record_.command;
    record_.command = RobotCommand();
    return nullptr;
  }
  record_.action = record_.command.motion_generation_finished ? record::TickAction::kFinished
                                                              : record::TickAction::kWritten;
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
  cycles_ = 1;
  chain_.Reset(state);
  return true;
}

void ControlTick::Generate(const RobotState& state) noexcept {
  const Deposit& deposit = exchange_.deposits.value();
  record_.command.message_id = state.message_id;
  chain_.Next(state, deposit.target, fresh_, cycles_, deposit.source_time, record_.command);
  cycles_ = 0;
  fresh_ = false;
  finished_for_ = deposit.finished ? finished_for_ + 1 : 0;
  record_.command.motion_generation_finished =
      !chain_.breach() && deposit.finished &&
      chain_.Finish(state, finished_for_ > kSourceRests, record_.command);

  record_.deposit_time = deposit.source_time;
  record_.q_ext = chain_.matched().joint.q;
  record_.dq_ext = chain_.matched().joint.dq;
  record_.stalled = chain_.stalled();
  record_.margin = chain_.margin();
  record_.kept_back = chain_.changed_joints();
}

}  // namespace twin::loop
