#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// How the configurations that reach a pose are sought.
struct PoseGoalOptions {
  /// Nearest to this they are wanted, rad; joint 7 is tried at near[6] + k q7_step, so what is
  /// there already is found exactly.
  JointVector near{};
  double q7_step = 0.02;       ///< rad, in [0.001, 1]
  double clearance = 0.01;     ///< m, >= 0, from everything
  double limit_margin = 0.01;  ///< rad, >= 0, from the joint limits
  double apart = 0.2;          ///< rad; of solutions nearer to one another the first counts
  std::size_t most = 16;       ///< no more than this many are returned
  std::uint64_t most_checks = 100'000;  ///< beyond these no further ones are looked at
};

/// Why there is no configuration.
enum class NoPoseReason {
  kOutOfReach,  ///< the arm is too short, or its base in the way of its wrist
  kLimits,      ///< each way to reach it needs a joint beyond its limits
  kCollision,   ///< each way within the limits touches something
};

struct NoPose {
  NoPoseReason reason = NoPoseReason::kOutOfReach;
  std::string text;  ///< what, by how much, which bodies
};

/// Joint configurations that put the flange at a pose, inside the joint limits and free of
/// collision, over all of the arm's redundancy: the ways of ArmSolutions at angles of joint 7 a
/// step apart, the nearest first (by Euclidean distance in joint space). Deterministic.
///
/// What is possible only in a window of joint 7 narrower than the step may be missed.
/// Threads: the world's. Counts its checks there.
/// @param O_T_F  flange in the base; rigid.
/// @throws InputError when an option is out of range, naming it.
[[nodiscard]] std::variant<std::vector<JointVector>, NoPose> ConfigurationsAt(
    const Transform& O_T_F, const JointLimits& limits, CollisionWorld& world,
    const PoseGoalOptions& options);

}  // namespace twin::planning
