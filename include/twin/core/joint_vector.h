#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace twin {

/// Number of joints of the arm.
inline constexpr std::size_t kJoints = 7;

/// One value per joint, base to wrist (joint 1 first), in rad, rad/s, rad/s^2, rad/s^3 or Nm as
/// stated at its use. A plain array instead of an Eigen type: threads, logs and the wire copy its
/// bytes, and its layout must not depend on the vector instructions of a user's build.
using JointVector = std::array<double, kJoints>;

/// Three Cartesian components, x y z.
using Vector3 = std::array<double, 3>;

/// Six Cartesian components: a twist [v; w] in m/s and rad/s, or a wrench [f; m] in N and Nm.
using Vector6 = std::array<double, 6>;

/// 3 x 3 matrix, column-major: element (row r, column c) is index 3 c + r.
using Matrix3 = std::array<double, 9>;

/// Homogeneous transform, 4 x 4 column-major: element (row r, column c) is index 4 c + r,
/// translation in 12, 13, 14. `X_AB` (or Franka's `A_T_B`) maps coordinates in frame B to
/// coordinates in frame A.
using Transform = std::array<double, 16>;

/// Angle of the third joint (rad) and the sign of the elbow flip (-1, 0 or +1). Source: FCI
/// protocol 5, robot state.
using Elbow = std::array<double, 2>;

/// The identity transform.
inline constexpr Transform kIdentityTransform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// Euclidean norm of one half of a twist or wrench, in its unit: of the translation or force (first
/// = 0), of the rotation or torque (first = 3).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] inline double HalfNorm(const Vector6& x, std::size_t first) noexcept {
  return std::sqrt(x[first] * x[first] + x[first + 1] * x[first + 1] + x[first + 2] * x[first + 2]);
}

}  // namespace twin
