#pragma once

#include <atomic>
#include <optional>

#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/onboard/base_controller.h"
#include "twin/plant/base_body.h"
#include "twin/rt/broadcast.h"
#include "twin/rt/latest_value.h"

namespace twin::robot {

/// A whole emulated mobile base: its controller and its body, cycle by cycle with the arm's, and
/// what others ask of it.
///
///     Drive()                     ---> LatestValue ---> Cycle(): controller, body
///     EmergencyStop(), Release()  ---> stopped_    --->
///     ReadState(), any threads    <--- Broadcast   <---
///
/// Threads: Cycle() and state() from the robot's; Drive() from one thread, the other requests from
/// any. Real-time: all calls are noexcept, wait for nobody and allocate nothing.
class BaseUnit {
 public:
  /// @param body  as the plant's Reset() left it; must outlive the unit. @param config  valid.
  BaseUnit(plant::BaseBody& body, const onboard::BaseConfig& config) noexcept
      : body_(body), controller_(config, body.sensors()) {}

  /// Once a cycle, before the plant's Step(): reads the body and tells its drives what to do in
  /// that step.
  void Cycle() noexcept TWIN_REALTIME;

  /// As backend::MobileBase's.
  void Drive(const BaseTwist& twist) noexcept TWIN_REALTIME;
  void EmergencyStop() noexcept TWIN_REALTIME { stopped_.store(true, std::memory_order_relaxed); }
  void Release() noexcept TWIN_REALTIME { stopped_.store(false, std::memory_order_relaxed); }
  [[nodiscard]] BaseState ReadState() const noexcept TWIN_REALTIME { return shown_.Read(); }

  /// As of the last cycle.
  [[nodiscard]] const BaseState& state() const noexcept { return controller_.state(); }

  /// Whether it neither moves nor is about to: time may stand still for it.
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  plant::BaseBody& body_;
  onboard::BaseController controller_;
  rt::LatestValue<BaseTwist> commands_;
  // Flags of their own, nothing else hangs on them: relaxed.
  std::atomic<bool> stopped_{false};
  std::atomic<bool> asked_{false};  ///< a command may wait for the next cycle
  rt::Broadcast<BaseState> shown_;
};

}  // namespace twin::robot
