#include "plugins/fci/fci_hand.h"

#include "twin/backend/refusal.h"

namespace twin::plugins {

fci::HandClient& FciHand::Client() const {
  const std::lock_guard lock(mutex_);
  if (!client_) client_.emplace(host_, port_, fci::ClientTimeout(), capture_, device_);
  return *client_;
}

HandTicket FciHand::Start(const HandCommand& command) {
  // The hand itself would report the failure without its cause.
  HandStart start;
  start.bad = FindBadValue(command, ReadState().max_width, device_);
  backend::RequireStarted(start, command);
  return Client().Start(command);
}

std::optional<HandResult> FciHand::Outcome(HandTicket ticket) const {
  return Client().Outcome(ticket);
}

HandState FciHand::ReadState() const {
  return Client().State();
}

}  // namespace twin::plugins
