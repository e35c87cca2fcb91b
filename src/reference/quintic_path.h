#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "twin/reference/trajectory.h"

namespace twin::reference::internal {

/// Fits a quintic spline through the waypoints: dq = ddq = 0 at both ends and at every stop,
/// continuous derivatives up to the fourth in between. O(points).
///
/// @param waypoints  at least two; uses positions and stops.
/// @param knots      one time per waypoint, the first 0, strictly increasing.
[[nodiscard]] std::vector<QuinticSegment> FitSpline(std::span<const Waypoint> waypoints,
                                                    std::span<const Duration> knots);

/// An extreme value and its location.
struct Extreme {
  double value = 0;         ///< signed
  double at_s = 0;          ///< time since the start of the trajectory
  std::size_t segment = 0;  ///< index of the segment
};

/// Extremes of a path per joint; for velocity, acceleration and jerk the largest magnitude.
struct PathExtremes {
  std::array<Extreme, kJoints> q_lowest{};   ///< rad
  std::array<Extreme, kJoints> q_highest{};  ///< rad
  std::array<Extreme, kJoints> dq{};         ///< rad/s
  std::array<Extreme, kJoints> ddq{};        ///< rad/s^2
  std::array<Extreme, kJoints> dddq{};       ///< rad/s^3
};

/// Finds the extremes at segment ends and at the roots of the next derivative. Roots are accurate
/// to 1e-9 of a segment's length, so extremes to about 1e-18 of a segment's range. O(segments).
///
/// @param segments  at least one.
[[nodiscard]] PathExtremes FindExtremes(std::span<const QuinticSegment> segments);

}  // namespace twin::reference::internal
