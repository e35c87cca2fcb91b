#pragma once

#include "twin/core/joint_vector.h"

namespace twin {

/// Whether a body can have this inertia, about its centre of mass: symmetric, and
///   Sigma = tr(I)/2 1 - I >= 0,
/// i.e. no principal moment is negative or exceeds the sum of the other two. Rods and points, with
/// zero moments, are limit cases and allowed. Tolerance: 1e-6 of the trace, for rounding in
/// rotation and output.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] bool IsInertiaOfBody(const Matrix3& I) noexcept;

}  // namespace twin
