#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/robot_errors.h"
#include "twin/onboard/violations.h"

// INT's comparisons of a value with its bound: with the tolerance kLimitTolerance; a NaN violates
// every bound.
//
// Threads: any. Real-time: noexcept, allocates nothing.
namespace twin::onboard::internal {

/// Whether a magnitude is at most its limit, >= 0.
[[nodiscard]] inline bool IsWithin(double magnitude, double limit) noexcept {
  return magnitude <= limit * (1 + kLimitTolerance);
}

/// The end of [low, high] that x exceeds; nullopt inside. A NaN exceeds the lower end.
[[nodiscard]] inline std::optional<double> BrokenBound(double x, double low, double high) noexcept {
  if (!(x >= low - kLimitTolerance * std::abs(low))) return low;
  if (!(x <= high + kLimitTolerance * std::abs(high))) return high;
  return std::nullopt;
}

/// Adds a violation for the first joint whose magnitude exceeds its limit.
inline void CheckJointMagnitudes(RobotError error, const JointVector& values,
                                 const JointVector& limits, std::uint64_t message_id,
                                 Violations& found) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (IsWithin(std::abs(values[i]), limits[i])) continue;
    found.Add({error, static_cast<std::int8_t>(i), values[i], std::copysign(limits[i], values[i]),
               message_id});
    return;
  }
}

/// Adds a violation for the first joint outside its range, with the end it exceeds.
inline void CheckJointRanges(RobotError error, const JointVector& values, const JointVector& low,
                             const JointVector& high, std::uint64_t message_id,
                             Violations& found) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::optional<double> bound = BrokenBound(values[i], low[i], high[i]);
    if (!bound) continue;
    found.Add({error, static_cast<std::int8_t>(i), values[i], *bound, message_id});
    return;
  }
}

}  // namespace twin::onboard::internal
