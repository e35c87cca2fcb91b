#pragma once

#include <optional>
#include <variant>

#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/onboard/gripper.h"
#include "twin/onboard/vacuum_pump.h"
#include "twin/plant/plant.h"

namespace twin::robot {

/// An emulated hand or vacuum gripper: controller and body, in the arm's cycle.
///
/// Threads: the robot's. Real-time: all calls are noexcept and allocate nothing.
class HandUnit {
 public:
  /// @param body  after the plant's Reset(); must outlive the unit.
  explicit HandUnit(plant::HandBody& body) noexcept : device_(Gripper(body)) {}
  explicit HandUnit(plant::SuctionBody& body) noexcept : device_(Pump(body)) {}

  /// Once per cycle, before the plant's Step(): reads the body and sets its drive for that step.
  void Cycle() noexcept TWIN_REALTIME {
    std::visit([](auto& one) { one.Cycle(); }, device_);
  }

  /// See onboard::Gripper and onboard::VacuumPump.
  HandStart Start(const HandCommand& command) noexcept TWIN_REALTIME {
    return std::visit([&](auto& one) { return one.controller.Start(command); }, device_);
  }
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const noexcept TWIN_REALTIME {
    return std::visit([&](const auto& one) { return one.controller.Outcome(ticket); }, device_);
  }
  [[nodiscard]] const HandState& state() const noexcept {
    const auto of = [](const auto& one) -> const HandState& { return one.controller.state(); };
    return std::visit(of, device_);
  }

 private:
  template <typename Body, typename Controller>
  struct Device {
    explicit Device(Body& of) noexcept : body(&of), controller(of.sensors()) {}
    void Cycle() noexcept { body->Drive(controller.Cycle(body->sensors())); }

    Body* body;
    Controller controller;
  };
  using Gripper = Device<plant::HandBody, onboard::Gripper>;
  using Pump = Device<plant::SuctionBody, onboard::VacuumPump>;

  std::variant<Gripper, Pump> device_;
};

}  // namespace twin::robot
