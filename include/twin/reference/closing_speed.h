#pragma once

#include <cmath>

#include "twin/core/realtime.h"

namespace twin::reference {

/// Speed at which a remaining distance closes and ends at rest: linear near the end, further out
/// with constant deceleration,
///   v = w d,  d <= a / w^2;   v = sqrt(a (2 d - a / w^2)) beyond.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param distance  d >= 0. @param deceleration  a > 0. @param omega  w, 1/s.
[[nodiscard]] inline double ClosingSpeed(double distance, double deceleration,
                                         double omega) noexcept {
  const double near_by = deceleration / (omega * omega);
  if (distance <= near_by) return omega * distance;
  return std::sqrt(deceleration * (2 * distance - near_by));
}

}  // namespace twin::reference
