#include "twin/robot/link.h"

namespace twin::robot {

template <typename Message>
Channel<Message>::Channel(const DirectionConfig& config, std::uint64_t seed,
                          const rt::FateStreams& streams, rt::EventQueue& events,
                          rt::EventOrder order)
    : fate_(config, seed, streams), events_(events), order_(order), slots_(kCapacity) {
  free_.reserve(kCapacity);
  for (std::size_t slot = kCapacity; slot > 0; --slot) free_.push_back(slot - 1);
}

template <typename Message>
void Channel<Message>::Send(const Message& message, rt::EventHandler& arrived,
                            std::uint32_t repeat) noexcept {
  const rt::Fate fate = fate_.Of(message.message_id, repeat);
  if (fate.lost || fate.delay > kLongestOnTheWay || free_.empty()) return;
  const std::size_t index = free_.back();
  free_.pop_back();
  slots_[index].message = message;
  slots_[index].copies = 1;
  events_.Schedule(events_.Now() + fate.delay, order_, arrived, index);
  if (!fate.duplicated || fate.duplicate_delay > kLongestOnTheWay) return;
  slots_[index].copies = 2;
  events_.Schedule(events_.Now() + fate.duplicate_delay, order_, arrived, index);
}

template <typename Message>
const Message& Channel<Message>::Receive(std::uint64_t token) noexcept {
  Slot& slot = slots_[token];
  if (--slot.copies == 0) free_.push_back(token);
  return slot.message;
}

template class Channel<RobotState>;
template class Channel<RobotCommand>;

StateLink::StateLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                     rt::EventHandler& state_ready)
    : channel_(config.state, seed, rt::kStateStreams, events, rt::EventOrder::kStateArrival),
      state_ready_(state_ready) {}

void StateLink::Send(const RobotState& state) noexcept {
  channel_.Send(state, *this);
}

void StateLink::OnEvent(Time now, std::uint64_t token) noexcept {
  const RobotState& state = channel_.Receive(token);
  if (state.message_id <= newest_.message_id) return;
  newest_ = state;
  arrival_ = now;
  has_new_ = true;
  state_ready_.OnEvent(now, newest_.message_id);
}

CommandLink::CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                         onboard::CommandInbox& inbox)
    : channel_(config.command, seed, rt::kCommandStreams, events, rt::EventOrder::kCommandArrival),
      inbox_(inbox) {}

void CommandLink::Send(const RobotCommand& command) noexcept {
  repeat_ = command.message_id == last_answered_ ? repeat_ + 1 : 0;
  last_answered_ = command.message_id;
  channel_.Send(command, *this, repeat_);
}

void CommandLink::OnEvent(Time now, std::uint64_t token) noexcept {
  inbox_.Push(channel_.Receive(token), now);
}

}  // namespace twin::robot
