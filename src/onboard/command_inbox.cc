#include "twin/onboard/command_inbox.h"

namespace twin::onboard {

void CommandInbox::Push(const RobotCommand& command, Time arrival) noexcept {
  if (count_ == kCapacity) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
    ++overflown_;
  }
  arrived_[(first_ + count_) % kCapacity] = {command, arrival};
  ++count_;
}

const RobotCommand* CommandInbox::Select(std::uint64_t oldest_id, std::uint64_t answered_id,
                                         Time deadline) noexcept {
  dropped_ = overflown_;
  overflown_ = 0;
  const RobotCommand* chosen = nullptr;
  while (count_ > 0 && arrived_[first_].arrival <= deadline) {
    const RobotCommand& command = arrived_[first_].command;
    if (command.message_id < oldest_id || command.message_id > answered_id) {
      ++dropped_;
    } else {
      if (chosen != nullptr) ++dropped_;
      chosen = &command;
    }
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  return chosen;
}

}  // namespace twin::onboard
