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

/// Options of the search for configurations that reach a pose.
struct PoseGoalOptions {
  /// Reference for "nearest", rad. Joint 7 is tried at near[6] + k q7_step, so a solution at `near`
  /// is found exactly.
  JointVector near{};
  double q7_step = 0.02;                ///< rad, in [0.001, 1]
  double clearance = 0.01;              ///< m, >= 0, from all parts
  double limit_margin = 0.01;           ///< rad, >= 0, from the joint limits
  double apart = 0.2;                   ///< rad; of closer solutions only the first is kept
  std::size_t most = 16;                ///< largest number of solutions returned
  std::uint64_t most_checks = 100'000;  ///< budget; further candidates are not checked
};

/// Why no configuration was found.
enum class NoPoseReason {
  kOutOfReach,  ///< the arm is too short, or the base blocks the wrist
  kLimits,      ///< every solution violates a joint limit
  kCollision,   ///< every solution within the limits collides
};

struct NoPose {
  NoPoseReason reason = NoPoseReason::kOutOfReach;
  std::string text;  ///< what, by how much, which bodies
};

/// Joint configurations that put the flange at a pose, within the joint limits and free of
/// collision, over the arm's whole redundancy: ArmSolutions at stepped angles of joint 7, the
/// nearest first (Euclidean distance in joint space). Deterministic.
///
/// May miss solutions that exist only in a window of joint 7 narrower than the step.
/// Threads: the world's. Its checks count there.
/// @param O_T_F  flange in the base; rigid.
/// @throws InputError naming an option out of range.
[[nodiscard]] std::variant<std::vector<JointVector>, NoPose> ConfigurationsAt(
    const Transform& O_T_F, const JointLimits& limits, CollisionWorld& world,
    const PoseGoalOptions& options);

}  // namespace twin::planning
