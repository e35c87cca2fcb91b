#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::model {

/// Product of two rigid transforms, X_AC = X_AB X_BC. Assumes last rows (0, 0, 0, 1) and does not
/// read them.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Transform Multiply(const Transform& X_AB,
                                 const Transform& X_BC) noexcept TWIN_REALTIME;

/// Inverse of a rigid transform: X_BA = [R^T, -R^T p] for X_AB = [R, p].
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @pre the rotation block of X_AB is orthonormal; it is transposed, not inverted.
[[nodiscard]] Transform Inverse(const Transform& X_AB) noexcept TWIN_REALTIME;

}  // namespace twin::model
