#pragma once

#include <Eigen/Geometry>

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

// Rotations of poses: between matrix, unit quaternion and rotation vector (axis times angle).
// All functions: any thread, real-time, no allocation.

/// Unit quaternion of the rotation block, which is orthonormalised if slightly oblique from
/// rounding.
[[nodiscard]] Eigen::Quaterniond Orientation(const Transform& X) noexcept;

[[nodiscard]] Eigen::Vector3d Position(const Transform& X) noexcept;

/// Pose from orientation and position, with the last row (0, 0, 0, 1).
[[nodiscard]] Transform Pose(const Eigen::Quaterniond& orientation,
                             const Eigen::Vector3d& position) noexcept;

/// Rotation vector, rad; its length is in [0, pi].
[[nodiscard]] Eigen::Vector3d Log(const Eigen::Quaterniond& rotation) noexcept;

/// Inverse of Log().
[[nodiscard]] Eigen::Quaterniond Exp(const Eigen::Vector3d& phi) noexcept;

/// Rotation vector from the orientation of `from` to that of `to`, base axes: log(R_to R_from^T).
[[nodiscard]] Eigen::Vector3d TurnBetween(const Transform& from, const Transform& to) noexcept;

/// Pose error from X to X_d: [p_d - p; log(R_d R^T)], base axes, m and rad.
[[nodiscard]] Vector6 WayTo(const Transform& X, const Transform& X_d) noexcept;

/// X rotated by phi (base axes) and moved to `position`. A rotation below the resolution of the
/// matrix leaves it unchanged bit for bit, so a reference at rest stays at rest.
[[nodiscard]] Transform Turned(const Transform& X, const Eigen::Vector3d& phi,
                               const Eigen::Vector3d& position) noexcept;

/// First and last three components of a twist: m/s and rad/s in its axes.
[[nodiscard]] inline Eigen::Vector3d Linear(const Vector6& twist) noexcept {
  return Eigen::Vector3d(twist.data());
}
[[nodiscard]] inline Eigen::Vector3d Angular(const Vector6& twist) noexcept {
  return Eigen::Vector3d(twist.data() + 3);
}

}  // namespace twin::model
