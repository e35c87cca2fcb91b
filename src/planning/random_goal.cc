#include "twin/planning/random_goal.h"

#include <fmt/format.h>

#include "planning/joint_space.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::planning {

JointVector RandomGoal(CollisionWorld& world, const JointLimits& limits, std::uint64_t seed,
                       const RandomGoalOptions& options) {
  RequireInRange("planning: random goal: least_distance", options.least_distance, 0, 5);
  RequireInRange("planning: random goal: clearance", options.clearance, 0, 1);
  RequireInRange("planning: random goal: limit_margin", options.limit_margin, 0, 0.3);
  RequireInRange("planning: random goal: most_draws", options.most_draws, 1, 1e6);
  const Random random(seed, RandomStream::kPlannerGoal);
  const auto [low, high] = Inside(limits, options.limit_margin);
  for (int n = 0; n < options.most_draws; ++n) {
    JointVector q;
    for (std::size_t i = 0; i < kJoints; ++i) {
      q[i] = low[i] + random.Uniform(static_cast<std::uint64_t>(n), static_cast<std::uint32_t>(i)) *
                          (high[i] - low[i]);
    }
    if (Distance(q, options.from) >= options.least_distance && world.IsFree(q, options.clearance)) {
      return q;
    }
  }
  throw InputError(fmt::format(
      "planning: none of {} random configurations is free by {:.1f} mm and {} rad from the start; "
      "ask for less of either, or make room in the scene",
      options.most_draws, options.clearance * 1e3, options.least_distance));
}

}  // namespace twin::planning
