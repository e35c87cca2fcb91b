#pragma once

#include <array>

#include "twin/teleop/operator_sample.h"

// Accepted ranges of a sample, from a wire or a file.
namespace twin::teleop {

/// Largest magnitude of an axis: 1 for a deflection; 10 for a handle's position, m or rad, beyond
/// the range of any hand-held device.
[[nodiscard]] constexpr double MostOfAxis(AxisKind kind) noexcept {
  return kind == AxisKind::kRate ? 1 : 10;
}

/// Counters of a sample, in the order of messages and files.
inline constexpr std::array kPresses{
    &OperatorSample::mode_presses,  &OperatorSample::gripper_presses,
    &OperatorSample::frame_presses, &OperatorSample::scale_presses,
    &OperatorSample::stop_presses,  &OperatorSample::release_presses,
    &OperatorSample::end_presses};

}  // namespace twin::teleop
