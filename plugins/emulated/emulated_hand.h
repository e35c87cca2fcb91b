#pragma once

#include <optional>

#include "twin/backend/hand.h"
#include "twin/backend/refusal.h"

namespace twin::plugins {

/// The emulated hand behind the hand seam; independent of what advances its time.
/// @tparam Robot  robot::Robot or robot::RealtimeRobot, with a hand mounted.
template <typename Robot>
class EmulatedHand final : public backend::Hand {
 public:
  /// @param robot  must outlive the hand.
  explicit EmulatedHand(Robot& robot) noexcept : robot_(robot) {}

  HandTicket Start(const HandCommand& command) override {
    const HandStart start = robot_.StartHand(command);
    backend::RequireStarted(start, command);
    return start.ticket;
  }
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const override {
    return robot_.HandOutcome(ticket);
  }
  [[nodiscard]] HandState ReadState() const override { return robot_.hand_state(); }

 private:
  Robot& robot_;
};

}  // namespace twin::plugins
