#pragma once

#include "twin/core/joint_vector.h"

namespace twin {

/// Whether a body can have this inertia, about its centre of mass: symmetric, and
///   Sigma = tr(I)/2 1 - I >= 0,
/// which says that no principal moment is negative, or above the other two together. A rod and a
/// point, whose moments are in part zero, are bodies in the limit. Within 1e-6 of the trace, for
/// what rotating an inertia and writing it down rounds.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] bool IsInertiaOfBody(const Matrix3& I) noexcept;

}  // namespace twin
