#pragma once

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

}  // namespace twin::reference::internal
