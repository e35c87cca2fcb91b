#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// Euclidean, rad.
inline double Distance(const JointVector& a, const JointVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kJoints; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

/// The point at `share` of the straight line from a (0) to b (1).
inline JointVector Between(const JointVector& a, const JointVector& b, double share) {
  JointVector q;
  for (std::size_t i = 0; i < kJoints; ++i) q[i] = a[i] + share * (b[i] - a[i]);
  return q;
}

/// A box in joint space, rad.
struct JointBounds {
  JointVector low{};
  JointVector high{};
};

/// The position limits reduced by a margin, and by where no motion towards them is possible.
/// @throws InputError if a joint's range becomes empty.
inline JointBounds Inside(const JointLimits& limits, double margin) {
  JointBounds bounds{limits.q_min, limits.q_max};
  for (std::size_t i = 0; i < kJoints; ++i) {
    bounds.low[i] += margin + limits.StillZone(i);
    bounds.high[i] -= margin + limits.StillZone(i);
    if (bounds.low[i] < bounds.high[i]) continue;
    throw InputError(
        fmt::format("planning: a margin of {} rad leaves nothing of joint {}'s range [{}, {}] rad",
                    margin, i + 1, limits.q_min[i], limits.q_max[i]));
  }
  return bounds;
}

/// Length of the path, rad.
inline double Length(const std::vector<JointVector>& path) {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += Distance(path[i - 1], path[i]);
  return sum;
}

/// Appended to Describe() in messages: the requested clearance, if the parts do not overlap.
inline std::string Wanted(const std::vector<Touch>& touches, double clearance) {
  if (touches.empty() || touches.front().distance < 0) return {};
  return fmt::format(" (a clearance of {:.1f} mm is asked for)", clearance * 1e3);
}

}  // namespace twin::planning
