#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "twin/core/joint_interface.h"
#include "twin/core/robot_state.h"

namespace twin {

/// Whether all values are finite.
///
/// Threads: any. Real-time: noexcept, allocates nothing; so are the overloads.
template <std::size_t N>
[[nodiscard]] bool IsFinite(const std::array<double, N>& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

[[nodiscard]] bool IsFinite(const JointSensors& sensors) noexcept;
[[nodiscard]] bool IsFinite(const RobotState& state) noexcept;

}  // namespace twin
