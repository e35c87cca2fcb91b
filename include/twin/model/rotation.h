#pragma once

#include <Eigen/Geometry>

#include "twin/core/joint_vector.h"

// Rotations of poses: between matrix, unit quaternion and rotation vector (axis times angle).
// All functions: any thread, real-time, no allocation.
namespace twin::model {

/// Unit quaternion of the rotation block; a block that rounding has made a little oblique is
/// straightened by it.
[[nodiscard]] Eigen::Quaterniond Orientation(const Transform& X) noexcept;

[[nodiscard]] Eigen::Vector3d Position(const Transform& X) noexcept;

/// The pose with this orientation and position, the last row (0, 0, 0, 1).
[[nodiscard]] Transform Pose(const Eigen::Quaterniond& orientation,
                             const Eigen::Vector3d& position) noexcept;

/// Rotation vector, rad; its length is in [0, pi].
[[nodiscard]] Eigen::Vector3d Log(const Eigen::Quaterniond& rotation) noexcept;

/// Inverse of Log().
[[nodiscard]] Eigen::Quaterniond Exp(const Eigen::Vector3d& phi) noexcept;

/// Rotation vector that turns pose `from` into the orientation of pose `to`, base axes:
/// log(R_to R_from^T).
[[nodiscard]] Eigen::Vector3d TurnBetween(const Transform& from, const Transform& to) noexcept;

/// X turned by phi (base axes) and moved to `position`. A turn below the resolution of a rotation
/// matrix leaves the rotation bit for bit: so a reference that comes to rest does rest.
[[nodiscard]] Transform Turned(const Transform& X, const Eigen::Vector3d& phi,
                               const Eigen::Vector3d& position) noexcept;

}  // namespace twin::model
