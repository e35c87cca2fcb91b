#pragma once

#include <optional>
#include <vector>

#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/reference/trajectory.h"

namespace twin::planning {

/// A timed path and its waypoints.
struct TimedPath {
  reference::Trajectory trajectory;
  std::vector<reference::Waypoint> waypoints;
};

/// Stops at every point and so stays on the straight segments. Each segment is a quintic at the
/// fastest pace within the shares: over a distance L its peaks are 15/8 L/T, 10/sqrt(3) L/T^2 and
/// 60 L/T^3.
/// @throws InputError where a joint would move where its robot permits no velocity.
/// @param pace  provides the shares. @pre path has two points or more; neighbours differ.
[[nodiscard]] TimedPath StopAndGo(const std::vector<JointVector>& path,
                                  const reference::Timing& pace, const JointLimits& limits);

/// Passes the points on a spline, stopping only at marked points; the spline departs from the
/// straight segments. Segment times are fitted in a few rounds, so that each segment uses up the
/// shares, not only one.
/// @param points  two or more, neighbours differ; their times are ignored.
/// @returns nullopt if the spline leaves the position limits.
[[nodiscard]] std::optional<TimedPath> RunThrough(const std::vector<reference::Waypoint>& points,
                                                  const reference::Timing& pace,
                                                  const JointLimits& limits);

/// Times a free path so that the result is free as well, as fast as possible: a spline, with added
/// points on segments where it collides; if that fails, with stops there; else stop and go, which
/// needs no check.
///
/// A spline counts as free if it keeps half the clearance at points between which nothing moves by
/// more than the clearance: then nothing touches between them either.
[[nodiscard]] TimedPath TimePath(const std::vector<JointVector>& path,
                                 const reference::Timing& pace, const JointLimits& limits,
                                 MotionChecker& checker);

}  // namespace twin::planning
