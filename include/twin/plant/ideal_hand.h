#pragma once

#include "twin/plant/hand_body.h"

namespace twin::plant {

/// The hand that does exactly what is desired, as far as its fingers reach: width = width_d, cut to
/// [0, 0.08] m. It meets nothing but the two ends of that way; there the fingers press with the
/// drive's force.
class IdealHand final : public HandBody {
 public:
  IdealHand() noexcept { Reset(); }

  void Reset() noexcept;
  /// Advances by 1 ms, as the plant it belongs to.
  void Step() noexcept TWIN_REALTIME;

  void Drive(const HandDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const HandSensors& sensors() const noexcept override { return sensors_; }

 private:
  HandDrive drive_;
  HandSensors sensors_;
};

}  // namespace twin::plant
