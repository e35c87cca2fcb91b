#pragma once

#include "twin/core/joint_vector.h"

// Rotations of poses, written down once more, so that what INT computes is compared with something
// that shares nothing with it.
namespace twin::test {

[[nodiscard]] double Norm(const Vector3& v);
[[nodiscard]] Vector3 Linear(const Vector6& twist);
[[nodiscard]] Vector3 Angular(const Vector6& twist);

/// Rotation vector of R_to R_from^T, base axes, rad.
[[nodiscard]] Vector3 RotationBetween(const Transform& from, const Transform& to);

/// The pose after one cycle of the twist [v; w]: p + v T, exp(w T) R.
[[nodiscard]] Transform After(const Transform& X, const Vector6& twist);

/// The twist that leads from one pose to the other in one cycle.
[[nodiscard]] Vector6 TwistBetween(const Transform& from, const Transform& to);

/// X turned by a rotation vector (base axes) about its own origin.
[[nodiscard]] Transform Turned(const Transform& X, const Vector3& phi);

/// Largest deviation of the rotation block from an orthonormal one.
[[nodiscard]] double Obliqueness(const Transform& X);

}  // namespace twin::test
