#include "twin/robot/link.h"

namespace twin::robot {
namespace {

/// Messages that may be on the way at once: what fits into 256 ms. One that would take longer is
/// overtaken by its successors and would be dropped on arrival anyway, so it counts as lost at
/// once.
constexpr std::size_t kOnTheWay = 256;
constexpr Duration kLongestDelay = kCycle * (kOnTheWay - 1);

}  // namespace

StateLink::StateLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                     rt::EventHandler& state_ready)
    : channel_(config.state_delay, config.state_loss, seed, RandomStream::kStateDelay,
               RandomStream::kStateLoss),
      events_(events),
      state_ready_(state_ready),
      on_the_way_(kOnTheWay) {}

void StateLink::Send(const RobotState& state) noexcept {
  const std::uint64_t id = state.message_id;
  const Duration delay = channel_.Delay(id);
  if (channel_.Loses(id) || delay > kLongestDelay) return;
  on_the_way_[id % kOnTheWay] = state;
  events_.Schedule(events_.Now() + delay, rt::EventOrder::kStateArrival, *this, id);
}

void StateLink::OnEvent(Time now, std::uint64_t message_id) noexcept {
  const RobotState& state = on_the_way_[message_id % kOnTheWay];
  if (state.message_id <= newest_.message_id) return;
  newest_ = state;
  arrival_ = now;
  has_new_ = true;
  state_ready_.OnEvent(now, message_id);
}

CommandLink::CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
                         onboard::CommandInbox& inbox)
    : channel_(config.command_delay, config.command_loss, seed, RandomStream::kCommandDelay,
               RandomStream::kCommandLoss),
      events_(events),
      inbox_(inbox),
      on_the_way_(kOnTheWay) {}

void CommandLink::Send(const RobotCommand& command) noexcept {
  // Keyed by the state it answers, so that a change in how many commands were sent before does not
  // change what happens to this one.
  const Duration delay = channel_.Delay(command.message_id);
  if (channel_.Loses(command.message_id) || delay > kLongestDelay) return;
  const std::uint64_t number = sent_++;
  on_the_way_[number % kOnTheWay] = command;
  events_.Schedule(events_.Now() + delay, rt::EventOrder::kCommandArrival, *this, number);
}

void CommandLink::OnEvent(Time now, std::uint64_t number) noexcept {
  inbox_.Push(on_the_way_[number % kOnTheWay], now);
}

}  // namespace twin::robot
