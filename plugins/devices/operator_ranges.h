#pragma once

#include <array>

#include "twin/teleop/operator_sample.h"

// Accepted ranges of a sample, from a wire or a file.
namespace twin::devices {

/// Largest magnitude of an axis: 1 for a deflection; 10 for a handle's position, m or rad, beyond
/// the range of any hand-held device.
[[nodiscard]] constexpr double MostOfAxis(teleop::AxisKind kind) noexcept {
  return kind == teleop::AxisKind::kRate ? 1 : 10;
}

/// Counters of a sample, in the order of messages and files.
inline constexpr std::array kPresses{
    &teleop::OperatorSample::mode_presses,  &teleop::OperatorSample::gripper_presses,
    &teleop::OperatorSample::frame_presses, &teleop::OperatorSample::scale_presses,
    &teleop::OperatorSample::stop_presses,  &teleop::OperatorSample::release_presses,
    &teleop::OperatorSample::end_presses};

}  // namespace twin::devices
