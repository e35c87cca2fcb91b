#pragma once

#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"

namespace twin::backend {

/// The only seam to a mobile base; beside Backend and Hand, as small, and as ignorant of what is
/// behind it: the twin now, a driver over a network later.
///
/// A twist holds until the next one, or until the base's watchdog finds it too old: then the base
/// brakes to a stand. Limits of speed and acceleration are the base's own; what exceeds them is
/// saturated.
///
/// Threads: where the drive has several, Drive() from one of them, the others from any. Real-time:
/// noexcept, allocates nothing, waits for nobody.
class MobileBase {
 public:
  virtual ~MobileBase() = default;

  /// Asks for a velocity from the base's next cycle on. Not finite: as zero. Without effect during
  /// an emergency stop.
  virtual void Drive(const BaseTwist& twist) noexcept TWIN_REALTIME = 0;

  /// Brakes as hard as the base can, and stays so until Release().
  virtual void EmergencyStop() noexcept TWIN_REALTIME = 0;

  /// Ends an emergency stop; the base stands until the next Drive().
  virtual void Release() noexcept TWIN_REALTIME = 0;

  /// The newest state.
  [[nodiscard]] virtual BaseState ReadState() const noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::backend
