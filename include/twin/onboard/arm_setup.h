#pragma once

#include "twin/onboard/measured_arm.h"
#include "twin/onboard/onboard_config.h"

namespace twin::onboard {

/// The frames and bodies that a configuration gives INT: end effector and load together.
///
/// Threads: any. Real-time: allocates nothing.
[[nodiscard]] ArmSetup SetupOf(const OnboardConfig& config) noexcept;

}  // namespace twin::onboard
