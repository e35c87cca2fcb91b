#pragma once

#include <optional>
#include <vector>

#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/reference/trajectory.h"

namespace twin::planning {

/// A path with times, and the points it was laid through.
struct TimedPath {
  reference::Trajectory trajectory;
  std::vector<reference::Waypoint> waypoints;
};

/// Rests at every point, so it stays on the straight ways. Each way is a quintic at the fastest
/// pace that the shares allow: over a distance L its peaks are 15/8 L/T, 10/sqrt(3) L/T^2 and
/// 60 L/T^3.
/// @param pace  its shares count. @pre path has two points or more, neighbours apart.
[[nodiscard]] TimedPath StopAndGo(const std::vector<JointVector>& path,
                                  const reference::Timing& pace, const JointLimits& limits);

/// Runs through the points, resting where they say so, on a spline that leaves the straight ways.
/// The time of each way is fitted in a few rounds, so that the shares are used up on each of them
/// rather than on one alone.
/// @param points  two or more, neighbours apart; their times do not count.
/// @returns nothing when the spline leaves the position limits.
[[nodiscard]] std::optional<TimedPath> RunThrough(const std::vector<reference::Waypoint>& points,
                                                  const reference::Timing& pace,
                                                  const JointLimits& limits);

/// The fastest way we know to follow a free path that is free itself: the spline, with points put
/// into the straight ways where it hits something; where that does not help, with stops there; or
/// else stop and go, which needs no check.
///
/// A spline counts as free when at points between which nothing moves further than the clearance
/// half the clearance is left: nothing touches between them either.
[[nodiscard]] TimedPath TimePath(const std::vector<JointVector>& path,
                                 const reference::Timing& pace, const JointLimits& limits,
                                 MotionChecker& checker);

}  // namespace twin::planning
