#pragma once

#include "twin/plant/hand_body.h"

namespace twin::plant {

/// A hand that follows the desired motion exactly within its range: width = width_d, cut to [0,
/// 0.08] m. It only touches its two stops, where the fingers press with the drive's force.
class IdealHand final : public HandBody {
 public:
  IdealHand() noexcept { Reset(); }

  void Reset() noexcept;
  /// Advances by 1 ms, like its plant.
  void Step() noexcept TWIN_REALTIME;

  void Drive(const HandDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const HandSensors& sensors() const noexcept override { return sensors_; }

 private:
  HandDrive drive_;
  HandSensors sensors_;
};

}  // namespace twin::plant
