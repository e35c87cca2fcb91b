#pragma once

#include "twin/core/joint_vector.h"

namespace twin::model {

/// A rigid body beyond the flange: end effector, load, or both.
struct Payload {
  double m = 0;     ///< mass, kg
  Vector3 F_x_C{};  ///< centre of mass in the flange frame, m
  Matrix3 I{};      ///< inertia about the centre of mass, flange axes, kg m^2
};

/// Combines both bodies, as FCI clients combine end effector and load: masses add; the centre of
/// mass is the mass-weighted mean; each inertia is moved to the flange, added, and moved to the
/// common centre. A body without mass contributes nothing; zero total mass gives zero. Source: FCI
/// protocol 5, fields the client derives itself.
[[nodiscard]] Payload Combine(const Payload& a, const Payload& b) noexcept;

}  // namespace twin::model
