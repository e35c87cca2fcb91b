#pragma once

#include <atomic>
#include <optional>

#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/onboard/base_controller.h"
#include "twin/plant/plant.h"
#include "twin/rt/broadcast.h"
#include "twin/rt/latest_value.h"

namespace twin::robot {

/// An emulated mobile base: controller and body, in the arm's cycle, and the requests to it.
///
///     Drive()                     ---> LatestValue ---> Cycle(): controller, body
///     EmergencyStop(), Release()  ---> stopped_    --->
///     ReadState(), any threads    <--- Broadcast   <---
///
/// Threads: Cycle() and state() from the robot's; Drive() from one thread, the other requests from
/// any. Real-time: all calls are noexcept, do not wait and allocate nothing.
class BaseUnit {
 public:
  /// A copy of all that changes in the unit, with the command that the next cycle takes.
  struct State {
    onboard::BaseController controller;
    std::optional<BaseTwist> command{};
    bool stopped = false;
  };

  /// @param body  after the plant's Reset(); must outlive the unit. @param config  valid.
  BaseUnit(plant::BaseBody& body, const onboard::BaseConfig& config) noexcept
      : body_(body), live_{.controller = onboard::BaseController(config, body.sensors())} {}

  /// On the robot's thread, between two cycles.
  [[nodiscard]] State Save() noexcept;
  /// Commands that have not taken effect are lost.
  void Restore(const State& state) noexcept;

  /// Once per cycle, before the plant's Step(): reads the body and sets its drives for that step.
  void Cycle() noexcept TWIN_REALTIME;

  /// See backend::MobileBase.
  void Drive(const BaseTwist& twist) noexcept TWIN_REALTIME;
  void EmergencyStop() noexcept TWIN_REALTIME { stopped_.store(true, std::memory_order_relaxed); }
  void Release() noexcept TWIN_REALTIME { stopped_.store(false, std::memory_order_relaxed); }
  [[nodiscard]] BaseState ReadState() const noexcept TWIN_REALTIME { return shown_.Read(); }

  /// State of the last cycle.
  [[nodiscard]] const BaseState& state() const noexcept { return live_.controller.state(); }

  /// Whether the base is at rest without a pending command, so that time may freeze.
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  plant::BaseBody& body_;
  /// Takes the newest command and the emergency stop into live_.
  void Take() noexcept TWIN_REALTIME;

  State live_;  ///< of the robot's thread
  rt::LatestValue<BaseTwist> commands_;
  // Independent flags that order nothing: relaxed.
  std::atomic<bool> stopped_{false};
  std::atomic<bool> asked_{false};  ///< a command may be pending for the next cycle
  rt::Broadcast<BaseState> shown_;
};

}  // namespace twin::robot
