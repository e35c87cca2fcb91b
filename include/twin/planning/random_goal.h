#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// Options of a random goal.
struct RandomGoalOptions {
  JointVector from{};          ///< rad; start of the motion
  double least_distance = 1;   ///< rad from the start (Euclidean), in [0, 5]
  double clearance = 0.01;     ///< m, >= 0
  double limit_margin = 0.05;  ///< rad, in [0, 0.3]
  int most_draws = 10'000;     ///< in [1, 10^6]
};

/// A collision-free configuration, drawn uniformly within the joint limits. The same world, seed
/// and options give the same result.
///
/// Threads: the world's. Its checks count there.
/// @throws InputError if an option is out of range, or none of most_draws was free and far enough.
[[nodiscard]] JointVector RandomGoal(CollisionWorld& world, const JointLimits& limits,
                                     std::uint64_t seed, const RandomGoalOptions& options = {});

}  // namespace twin::planning
