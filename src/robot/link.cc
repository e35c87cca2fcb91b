#include "twin/robot/link.h"

namespace twin::robot {

StateLink::StateLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                     rt::EventHandler& state_ready)
    : channel_(config.state, seed, faults::kStateStreams, events, rt::EventOrder::kStateArrival),
      state_ready_(&state_ready) {}

void StateLink::Send(const RobotState& state) noexcept {
  channel_.Send(state, *this);
}

void StateLink::OnEvent(Time now, std::uint64_t token) noexcept {
  const RobotState& state = channel_.Receive(token);
  if (state.message_id <= newest_.message_id) return;
  newest_ = state;
  arrival_ = now;
  has_new_ = true;
  state_ready_->OnEvent(now, newest_.message_id);
}

CommandLink::CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                         onboard::CommandInbox& inbox)
    : channel_(config.command, seed, faults::kCommandStreams, events,
               rt::EventOrder::kCommandArrival),
      inbox_(&inbox) {}

void CommandLink::Send(const RobotCommand& command) noexcept {
  repeat_ = command.message_id == last_answered_ ? repeat_ + 1 : 0;
  last_answered_ = command.message_id;
  channel_.Send(command, *this, repeat_);
}

void CommandLink::OnEvent(Time now, std::uint64_t token) noexcept {
  inbox_->Push(channel_.Receive(token), now);
}

}  // namespace twin::robot
