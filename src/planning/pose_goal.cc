#include "twin/planning/pose_goal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "planning/joint_space.h"
#include "twin/core/error.h"
#include "twin/planning/arm_solutions.h"

namespace twin::planning {
namespace {

/// Solutions of a pose that the joint limits permit.
struct Candidates {
  std::vector<JointVector> inside;  ///< the nearest first
  bool any = false;                 ///< true if any solution exists, with or without limits
  // Of the solution with the smallest violation:
  double least_excess = std::numeric_limits<double>::infinity();  ///< rad
  std::size_t joint = 0;
  double value = 0;

  void Take(const JointVector& q, const JointVector& low, const JointVector& high) {
    any = true;
    double excess = -std::numeric_limits<double>::infinity();
    std::size_t worst = 0;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double beyond = std::max(low[i] - q[i], q[i] - high[i]);
      if (beyond > excess) {
        excess = beyond;
        worst = i;
      }
    }
    if (excess <= 0) {
      inside.push_back(q);
    } else if (excess < least_excess) {
      least_excess = excess;
      joint = worst;
      value = q[worst];
    }
  }
};

Candidates FindCandidates(const Transform& O_T_F, const JointVector& low, const JointVector& high,
                          const PoseGoalOptions& options) {
  Candidates found;
  const double q7 = std::clamp(options.near[6], low[6], high[6]);
  const auto below = static_cast<int>(std::floor((q7 - low[6]) / options.q7_step));
  const auto above = static_cast<int>(std::floor((high[6] - q7) / options.q7_step));
  for (int k = -below; k <= above; ++k) {
    const ArmSolutions ways(O_T_F, q7 + k * options.q7_step, options.near[0]);
    for (const JointVector& q : ways.all()) found.Take(q, low, high);
  }
  std::stable_sort(found.inside.begin(), found.inside.end(),
                   [&](const JointVector& a, const JointVector& b) {
                     return Distance(a, options.near) < Distance(b, options.near);
                   });
  return found;
}

void Validate(const PoseGoalOptions& options) {
  for (const double q : options.near) RequireInRange("planning: pose goal: near", q, -10, 10);
  RequireInRange("planning: pose goal: q7_step", options.q7_step, 0.001, 1);
  RequireInRange("planning: pose goal: clearance", options.clearance, 0, 1);
  RequireInRange("planning: pose goal: limit_margin", options.limit_margin, 0, 1);
  RequireInRange("planning: pose goal: apart", options.apart, 0, 100);
  RequireInRange("planning: pose goal: most", static_cast<double>(options.most), 1, 1e6);
  RequireInRange("planning: pose goal: most_checks", static_cast<double>(options.most_checks), 1,
                 1e12);
}

}  // namespace

std::variant<std::vector<JointVector>, NoPose> ConfigurationsAt(const Transform& O_T_F,
                                                                const JointLimits& limits,
                                                                CollisionWorld& world,
                                                                const PoseGoalOptions& options) {
  Validate(options);
  const auto [low, high] = Inside(limits, options.limit_margin);
  const Candidates candidates = FindCandidates(O_T_F, low, high, options);
  if (!candidates.any) {
    return NoPose{NoPoseReason::kOutOfReach,
                  fmt::format("the flange cannot be at ({:.3f}, {:.3f}, {:.3f}) m in this "
                              "orientation: out of the arm's reach",
                              O_T_F[12], O_T_F[13], O_T_F[14])};
  }
  if (candidates.inside.empty()) {
    const std::size_t i = candidates.joint;
    return NoPose{NoPoseReason::kLimits,
                  fmt::format("each way to the pose breaks a joint limit; the nearest to be "
                              "possible needs joint {} at {:.4f} rad, beyond [{:.4f}, {:.4f}]",
                              i + 1, candidates.value, low[i], high[i])};
  }
  std::vector<JointVector> free;
  const std::uint64_t end = world.checks() + options.most_checks;
  for (const JointVector& q : candidates.inside) {
    const bool is_new = std::none_of(free.begin(), free.end(), [&](const JointVector& other) {
      return Distance(q, other) < options.apart;
    });
    if (is_new && world.IsFree(q, options.clearance)) free.push_back(q);
    if (free.size() == options.most || world.checks() == end) break;
  }
  if (!free.empty()) return free;
  const auto touches = world.Touches(candidates.inside.front(), options.clearance);
  return NoPose{
      NoPoseReason::kCollision,
      fmt::format("each of {} ways to the pose is in collision; in the nearest {}{}",
                  candidates.inside.size(), Describe(touches), Wanted(touches, options.clearance))};
}

}  // namespace twin::planning
