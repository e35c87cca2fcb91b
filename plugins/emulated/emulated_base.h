#pragma once

#include "twin/backend/mobile_base.h"
#include "twin/robot/base_unit.h"

namespace twin::plugins {

/// The emulated mobile base behind the base seam; independent of what advances its time.
class EmulatedBase final : public backend::MobileBase {
 public:
  /// @param unit  must outlive the base; null without a mobile base, and then never used.
  explicit EmulatedBase(robot::BaseUnit* unit) noexcept : unit_(unit) {}

  void Drive(const BaseTwist& twist) noexcept override { unit_->Drive(twist); }
  void EmergencyStop() noexcept override { unit_->EmergencyStop(); }
  void Release() noexcept override { unit_->Release(); }
  [[nodiscard]] BaseState ReadState() const noexcept override { return unit_->ReadState(); }

 private:
  robot::BaseUnit* unit_;
};

}  // namespace twin::plugins
