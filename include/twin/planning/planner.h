#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/reference/trajectory.h"

namespace twin::planning {

/// How motions are planned.
struct PlannerOptions {
  /// Collision checks that one plan may take: a budget in checks, not in time, so that planning
  /// repeats on any machine.
  std::uint64_t most_checks = 100'000;
  /// What is kept from obstacles and from the arm itself, m, in [0.001, 0.1]: by start, goal and
  /// every point where a way is checked. Between those nothing moves by more than twice this, so
  /// nothing touches there either.
  double clearance = 0.01;
  double limit_margin = 0.01;  ///< rad, kept from the joint limits where start and goal do so too
  double range = 1.0;          ///< length of a branch of the search trees, rad
  int shortcuts = 150;         ///< attempts to shorten the path
  reference::Timing pace{};    ///< shares of the limits; without a duration

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// What a plan took.
struct PlanStatistics {
  std::uint64_t checks = 0;   ///< of configurations against the world
  Duration wall{};            ///< by the clock given; repeats by none but a virtual one
  double found_length = 0;    ///< of the path as found, rad (Euclidean)
  double path_length = 0;     ///< and after shortening
  std::size_t waypoints = 0;  ///< of the trajectory
};

/// A motion that can be executed: at rest at both ends, inside the limits, free of collision.
struct Plan {
  reference::Trajectory trajectory;
  std::vector<reference::Waypoint> waypoints;  ///< what the trajectory was laid through, with times
  PlanStatistics statistics;
};

/// Why there is no plan.
enum class PlanFailureReason : std::uint8_t {
  kStartInCollision,  ///< or too near to something; move the arm away first
  kGoalInCollision,   ///< or too near to something
  kGoalUnreachable,   ///< no configuration within the joint limits reaches it
  kBudgetExhausted,   ///< no path found within most_checks; there may be none
};

struct PlanFailure {
  PlanFailureReason reason = PlanFailureReason::kBudgetExhausted;
  std::string text;  ///< what, where, which bodies, and what to do
  PlanStatistics statistics;
};

using PlanOutcome = std::variant<Plan, PlanFailure>;

/// Plans motions of the arm through joint space, around what a world holds.
///
/// A path of straight ways is sought by RRT-Connect (OMPL), shortened, and laid out in time as a
/// quintic spline, jerk bounded, within the given shares of the joint limits
/// (reference::Trajectory). The spline leaves the straight ways, so it is checked by itself, every
/// cycle; where it hits, points are put in, and in the end it stops at each turning point.
///
/// The same world, question and seed give the same plan to the bit, whatever was planned before.
/// The hand's width and what is held are the world's, and stay as they are over a motion.
///
/// Threads: the world's. Not for real-time code.
class Planner {
 public:
  /// @param world, clock  must outlive the planner. @param limits  valid.
  /// @throws InputError for options out of range.
  Planner(CollisionWorld& world, const JointLimits& limits, const Clock& clock,
          const PlannerOptions& options = {});

  /// @param start, goal  rad. @param seed  of all that is random.
  /// @throws InputError when the start or a number is not inside the joint limits, naming joint,
  /// value and range, and when start and goal coincide (within 1e-6 rad).
  [[nodiscard]] PlanOutcome ToConfiguration(const JointVector& start, const JointVector& goal,
                                            std::uint64_t seed);

  /// To a pose of the flange, by any configuration that reaches it (ConfigurationsAt), the nearest
  /// first. @param O_T_F  flange in the base; rigid. @throws InputError as above.
  [[nodiscard]] PlanOutcome ToPose(const JointVector& start, const Transform& O_T_F,
                                   std::uint64_t seed);

 private:
  CollisionWorld& world_;
  JointLimits limits_;
  const Clock& clock_;
  PlannerOptions options_;
};

}  // namespace twin::planning
