#pragma once

#include <algorithm>
#include <cstddef>

#include <Eigen/Core>

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/closing_speed.h"
#include "twin/reference/rejoining_generator.h"

namespace twin::reference {

/// A joint's limits, rad/s and its derivatives.
[[nodiscard]] inline CartesianBound BoundOf(const JointLimits& limits, std::size_t joint) noexcept {
  return {limits.dq_max[joint], limits.ddq_max[joint], limits.dddq_max[joint]};
}

/// The law of RejoiningGenerator, for a joint (D = 1) or a vector of three (D = 3), with saturated
/// norms.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param e, de, dde  the robot's reference minus the source's.
/// @param v, a  of the source. @param limits  of both together.
/// @returns velocity of the next command relative to the source: e' + T (e'' + T j).
template <int D>
[[nodiscard]] Eigen::Matrix<double, D, 1> CorrectingVelocity(
    const Eigen::Matrix<double, D, 1>& e, const Eigen::Matrix<double, D, 1>& de,
    const Eigen::Matrix<double, D, 1>& dde, double v, double a,
    const CartesianBound& limits) noexcept TWIN_REALTIME {
  using Vector = Eigen::Matrix<double, D, 1>;
  // Loops of position, velocity and acceleration, 1/s, each four times faster than the outer one.
  constexpr double kOmega1 = 25;
  constexpr double kOmega2 = 100;
  constexpr double kOmega3 = 400;
  constexpr double kShare = RejoiningGenerator::kShare;
  constexpr double kMostShare = RejoiningGenerator::kMostShare;
  const auto saturated = [](const Vector& x, double most) -> Vector {
    const double norm = x.norm();
    return norm > most ? Vector(x * (most / norm)) : x;
  };
  const double dp_max =
      std::max(RejoiningGenerator::kVelocityShare * limits.dp_max, kMostShare * limits.dp_max - v);
  const double ddp_max = std::max(kShare * limits.ddp_max, kMostShare * limits.ddp_max - a);
  const double distance = e.norm();
  const double speed = std::min(ClosingSpeed(distance, kShare * ddp_max, kOmega1), dp_max);
  const Vector wanted = distance > 0 ? Vector(e * (-speed / distance)) : Vector(Vector::Zero());
  const Vector acceleration = saturated(kOmega2 * (wanted - de), ddp_max);
  const Vector jerk = saturated(kOmega3 * (acceleration - dde), kShare * limits.dddp_max);
  return de + kT * (dde + kT * jerk);
}

}  // namespace twin::reference
