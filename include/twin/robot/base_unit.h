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
  /// @param body  after the plant's Reset(); must outlive the unit. @param config  valid.
  BaseUnit(plant::BaseBody& body, const onboard::BaseConfig& config) noexcept
      : body_(body), controller_(config, body.sensors()) {}

  /// Once per cycle, before the plant's Step(): reads the body and sets its drives for that step.
  void Cycle() noexcept TWIN_REALTIME;

  /// See backend::MobileBase.
  void Drive(const BaseTwist& twist) noexcept TWIN_REALTIME;
  void EmergencyStop() noexcept TWIN_REALTIME { stopped_.store(true, std::memory_order_relaxed); }
  void Release() noexcept TWIN_REALTIME { stopped_.store(false, std::memory_order_relaxed); }
  [[nodiscard]] BaseState ReadState() const noexcept TWIN_REALTIME { return shown_.Read(); }

  /// State of the last cycle.
  [[nodiscard]] const BaseState& state() const noexcept { return controller_.state(); }

  /// Whether the base is at rest without a pending command, so that time may freeze.
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  plant::BaseBody& body_;
  onboard::BaseController controller_;
  rt::LatestValue<BaseTwist> commands_;
  // Independent flags that order nothing: relaxed.
  std::atomic<bool> stopped_{false};
  std::atomic<bool> asked_{false};  ///< a command may be pending for the next cycle
  rt::Broadcast<BaseState> shown_;
};

}  // namespace twin::robot
