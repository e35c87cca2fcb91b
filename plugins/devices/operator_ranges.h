#pragma once

#include <array>

#include "twin/teleop/operator_sample.h"

// What is accepted of a sample, from a wire or from a file.
namespace twin::devices {

/// The largest magnitude of an axis: 1 of a deflection; of a handle's place 10, m or rad, which no
/// hand's device exceeds.
[[nodiscard]] constexpr double MostOfAxis(teleop::AxisKind kind) noexcept {
  return kind == teleop::AxisKind::kRate ? 1 : 10;
}

/// The counters of a sample, in the order in which messages and files have them.
inline constexpr std::array kPresses{
    &teleop::OperatorSample::mode_presses,  &teleop::OperatorSample::gripper_presses,
    &teleop::OperatorSample::frame_presses, &teleop::OperatorSample::scale_presses,
    &teleop::OperatorSample::stop_presses,  &teleop::OperatorSample::release_presses,
    &teleop::OperatorSample::end_presses};

}  // namespace twin::devices
