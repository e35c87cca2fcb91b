#pragma once

#include <optional>

#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/onboard/gripper.h"
#include "twin/plant/plant.h"

namespace twin::robot {

/// An emulated hand: controller and body, in the arm's cycle.
///
/// Threads: the robot's. Real-time: all calls are noexcept and allocate nothing.
class HandUnit {
 public:
  /// @param body  after the plant's Reset(); must outlive the unit.
  explicit HandUnit(plant::HandBody& body) noexcept : body_(&body), gripper_(body.sensors()) {}

  /// Once per cycle, before the plant's Step(): reads the body and sets its drive for that step.
  void Cycle() noexcept TWIN_REALTIME { body_->Drive(gripper_.Cycle(body_->sensors())); }

  /// See onboard::Gripper.
  HandStart Start(const HandCommand& command) noexcept TWIN_REALTIME {
    return gripper_.Start(command);
  }
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const noexcept TWIN_REALTIME {
    return gripper_.Outcome(ticket);
  }
  [[nodiscard]] const HandState& state() const noexcept { return gripper_.state(); }

 private:
  plant::HandBody* body_;
  onboard::Gripper gripper_;
};

}  // namespace twin::robot
