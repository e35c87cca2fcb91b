#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
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

/// Options of motion planning.
struct PlannerOptions {
  /// Budget of collision checks per plan. It counts checks, not time, so that plans are the same on
  /// any machine.
  std::uint64_t most_checks = 100'000;
  /// Clearance from obstacles and the arm itself, m, in [0.001, 0.1], of start, goal and all
  /// checked points of a path. Between checked points nothing moves by more than twice this, so
  /// nothing touches there either.
  double clearance = 0.01;
  double limit_margin = 0.01;  ///< rad, from the joint limits; less at a closer start or goal
  double range = 1.0;          ///< length of a branch of the search trees, rad
  int shortcuts = 150;         ///< attempts to shorten the path
  reference::Timing pace{};    ///< shares of the limits; without a duration
  /// Asked about once per 100 checks; true ends the search as an exhausted budget does. May be
  /// empty.
  std::function<bool()> stopped{};

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Costs and results of a plan.
struct PlanStatistics {
  std::uint64_t checks = 0;   ///< of configurations against the world
  Duration wall{};            ///< by the given clock; reproducible only with a virtual one
  double found_length = 0;    ///< of the path found first, rad (Euclidean)
  double path_length = 0;     ///< after shortening
  std::size_t waypoints = 0;  ///< of the trajectory
  Duration duration{};        ///< of the trajectory
};

/// An executable motion: at rest at both ends, within the limits, free of collision.
struct Plan {
  reference::Trajectory trajectory;
  std::vector<reference::Waypoint> waypoints;  ///< of the trajectory, with times
  PlanStatistics statistics;
};

/// Reason for a failed plan.
enum class PlanFailureReason : std::uint8_t {
  kStartInCollision,  ///< or too close to a part; move the arm away first
  kGoalInCollision,   ///< or too close to a part
  kGoalUnreachable,   ///< no configuration within the joint limits reaches it
  kBudgetExhausted,   ///< no path found within most_checks; one may exist
};

struct PlanFailure {
  PlanFailureReason reason = PlanFailureReason::kBudgetExhausted;
  std::string text;  ///< what, where, which bodies, and the cure
  PlanStatistics statistics;
};

using PlanOutcome = std::variant<Plan, PlanFailure>;

/// Plans joint-space motions of the arm around the bodies of a world.
///
/// RRT-Connect (OMPL) finds a path of straight segments, which is shortened and timed as a quintic
/// spline with bounded jerk, within the given shares of the joint limits (reference::Trajectory).
/// The spline departs from the segments, so it is checked in every cycle. Where it collides, points
/// are added; as the last resort the motion stops at each turning point.
///
/// The same world, query and seed give the same plan bit by bit, whatever was planned before. The
/// hand's width and a held object belong to the world and stay constant over a motion. Plans keep
/// the world's limits (CollisionWorld::SetLimits), caps on speed included.
///
/// Threads: the world's. Not for real-time code.
class Planner {
 public:
  /// @param world, clock  must outlive the planner. @param limits  must be valid.
  /// @throws InputError for options out of range.
  Planner(CollisionWorld& world, const JointLimits& limits, const Clock& clock,
          const PlannerOptions& options = {});

  /// @param start, goal  rad. @param seed  of all random numbers.
  /// @throws InputError naming joint, value and range if start or goal is outside the joint limits
  /// or not finite, and if start and goal coincide (within 1e-6 rad).
  [[nodiscard]] PlanOutcome ToConfiguration(const JointVector& start, const JointVector& goal,
                                            std::uint64_t seed);

  /// Plans to a pose of the flange, by any configuration that reaches it (ConfigurationsAt), the
  /// nearest first. @param O_T_F  flange in the base; rigid. @throws InputError as above.
  [[nodiscard]] PlanOutcome ToPose(const JointVector& start, const Transform& O_T_F,
                                   std::uint64_t seed);

 private:
  CollisionWorld& world_;
  JointLimits limits_;
  const Clock& clock_;
  PlannerOptions options_;
};

}  // namespace twin::planning
