#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// Where a random goal may be.
struct RandomGoalOptions {
  JointVector from{};          ///< rad; where the motion would begin
  double least_distance = 1;   ///< rad from there (Euclidean), in [0, 5]
  double clearance = 0.01;     ///< m, >= 0
  double limit_margin = 0.05;  ///< rad, in [0, 0.3]
  int most_draws = 10'000;     ///< in [1, 10^6]
};

/// A configuration that is free of collision, drawn uniformly from the joint limits. The same
/// world, seed and options give the same one.
///
/// Threads: the world's. Counts its checks there.
/// @throws InputError when an option is out of range, or when none of most_draws was free and far
/// enough.
[[nodiscard]] JointVector RandomGoal(CollisionWorld& world, const JointLimits& limits,
                                     std::uint64_t seed, const RandomGoalOptions& options = {});

}  // namespace twin::planning
