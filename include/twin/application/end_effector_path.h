#pragma once

#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/reference/trajectory.h"

namespace twin::application {

/// Of points along a way, those that a picture shows: the first, and then each that is at least 2
/// cm from the last; further where they would be more than a picture takes
/// (render::Ghost::kMostPoints).
///
/// Threads: any. @pre at least one.
[[nodiscard]] std::vector<Vector3> Thinned(const std::vector<Vector3>& points);

/// The way of the end effector along a trajectory, for a picture; as Thinned().
///
/// Threads: any. @param F_T_EE  end effector in the flange. @returns base frame, m.
[[nodiscard]] std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                                   const Transform& F_T_EE);

}  // namespace twin::application
