#pragma once

#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"

namespace twin::backend {

/// The only seam to a mobile base, beside Backend and Hand and independent of what implements it:
/// today the twin, later a driver over a network.
///
/// A twist holds until the next one, or until the base's watchdog finds it too old and brakes the
/// base to a stop. The base saturates speed and acceleration at its own limits.
///
/// Threads: Drive() from one thread, the others from any, if the drive has several. Real-time:
/// noexcept, does not allocate, never waits.
class MobileBase {
 public:
  virtual ~MobileBase() = default;

  /// Requests a velocity from the base's next cycle on. A twist that is not finite counts as zero.
  /// No effect during an emergency stop.
  virtual void Drive(const BaseTwist& twist) noexcept TWIN_REALTIME = 0;

  /// Brakes as hard as the base can and holds it until Release().
  virtual void EmergencyStop() noexcept TWIN_REALTIME = 0;

  /// Ends an emergency stop; the base stays at rest until the next Drive().
  virtual void Release() noexcept TWIN_REALTIME = 0;

  /// The newest state.
  [[nodiscard]] virtual BaseState ReadState() const noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::backend
