#pragma once

#include <cmath>
#include <cstddef>

#include "twin/core/joint_vector.h"

namespace twin {

/// Euclidean norm of one half of a twist or wrench, in its unit: of the translation or force (first
/// = 0), of the rotation or torque (first = 3).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] inline double HalfNorm(const Vector6& x, std::size_t first) noexcept {
  return std::sqrt(x[first] * x[first] + x[first + 1] * x[first + 1] + x[first + 2] * x[first + 2]);
}

}  // namespace twin
