#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "reference/fixed_point/polytope.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference {

/// A joint in units of its own bounds: x = ((q - middle) / half range, v / V, a / A), u = j / J.
struct ScaledJoint {
  explicit ScaledJoint(const AxisBounds& bounds);

  [[nodiscard]] Eigen::Vector3d Scaled(const AxisState& x) const;
  [[nodiscard]] AxisState Unscaled(const Eigen::Vector3d& x) const;

  double middle;          ///< rad
  Eigen::Vector3d units;  ///< half range, V, A
  Eigen::Matrix3d A;      ///< a step, x+ = A x + b u
  Eigen::Vector3d b;
};

/// The largest set of states within the bounds that can be kept for ever whatever up to n commands
/// in a row are lost, found without the closed form:
///   W(0) = X,   W(k+1) = the x with A^i x in X and in Pre(W(k)) for every i <= n,
/// where X is the box of bounds, A a step without a command, and Pre(W) what a command leads into W
/// from. Each W(k) holds the next; where one is its own successor, that is the set.
struct FixedPoint {
  Polytope set;
  int steps = 0;        ///< until it no longer changed
  double residual = 0;  ///< how far the last step reached into the set, in scaled units
};

/// @param bounds  as a ViableAxis keeps them. @throws std::runtime_error when it does not converge.
[[nodiscard]] FixedPoint FixedPointOf(const AxisBounds& bounds, int lost);

/// W(k+1) of W(k).
[[nodiscard]] Polytope Shrunk(const Polytope& set, const ScaledJoint& joint, int lost);

/// How a fixed point and the closed form of ViableAxis compare on states of which three quarters
/// are near the fixed point's border, a 10^-2nd to a 10^-9th of a bound off it, in position, in
/// velocity or in acceleration.
struct Agreement {
  std::uint64_t states = 0;
  std::uint64_t viable = 0;         ///< by the closed form
  std::uint64_t near_border = 0;    ///< within 1e-2 of a bound
  std::uint64_t disagreements = 0;  ///< beyond kBeyond off either border
  double differ_within = 0;         ///< the farthest off a border that they differ
};

/// Off a border in scaled units: 1e-9 of half the range, of V, of A.
constexpr double kBeyond = 1e-9;

/// @pre the fixed point is that of axis.kept() and axis.lost().
[[nodiscard]] Agreement Compare(const FixedPoint& found, const ViableAxis& axis,
                                std::uint64_t states, std::uint64_t seed);

/// The smallest range for which the closed form's set is its own successor, rad, to a 10^-6th:
/// below it a joint may have to brake both ways at once. @param bounds  the range does not count.
[[nodiscard]] double LeastRange(const AxisBounds& bounds, int lost);

}  // namespace twin::reference
