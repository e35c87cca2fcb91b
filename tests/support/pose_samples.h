#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/random.h"

// Poses for tests, and what is asked of them.
namespace twin::test {

/// The pose turned by phi (axis times angle, rad) from the identity, at p.
Transform PoseOf(const Eigen::Vector3d& phi, const Eigen::Vector3d& p);

Eigen::Matrix3d RotationOf(const Transform& X);
Eigen::Vector3d PositionOf(const Transform& X);

/// log(R_to R_from^T), rad.
Eigen::Vector3d RotationVector(const Transform& from, const Transform& to);

/// How far the rotation is from orthonormal: largest element of R R^T - 1.
double Obliqueness(const Transform& X);

/// Each component in [-1, 1].
Eigen::Vector3d RandomVector(const Random& random, std::uint64_t tick, std::uint32_t draw);

/// A pose within the arm's reach, turned by up to 3 rad.
Transform RandomPose(const Random& random, std::uint64_t tick);

}  // namespace twin::test
