#include "twin/planning/planner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "planning/joint_space.h"
#include "planning/motion_checker.h"
#include "planning/path_timing.h"
#include "planning/shortcuts.h"
#include "planning/tree_search.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/planning/pose_goal.h"

namespace twin::planning {
namespace {

/// Shortest motion, rad per joint; trajectories permit no shorter segment.
constexpr double kLeastMotion = 1e-6;

/// Reciprocal share of the budget that shortening leaves for the spline.
constexpr std::uint64_t kKeptPart = 5;

bool Coincide(const JointVector& a, const JointVector& b) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(a[i] - b[i]) >= kLeastMotion) return false;
  }
  return true;
}

/// The computation of one plan.
class Attempt {
 public:
  Attempt(CollisionWorld& world, const JointLimits& limits, const Clock& clock,
          const PlannerOptions& options)
      : world_(world),
        limits_(limits),
        clock_(clock),
        options_(options),
        begin_(clock.Now()),
        first_check_(world.checks()),
        checker_(world, options.clearance, options.most_checks, options.stopped) {}

  [[nodiscard]] PlanFailure Fail(PlanFailureReason reason, std::string text) const {
    return {reason, "planning: " + std::move(text), Statistics()};
  }

  /// Describes the collision at q; nullopt if q is free.
  [[nodiscard]] std::optional<PlanFailure> Obstructed(const JointVector& q, const char* which,
                                                      PlanFailureReason reason) {
    if (world_.IsFree(q, options_.clearance)) return std::nullopt;
    const auto touches = world_.Touches(q, options_.clearance);
    return Fail(reason, fmt::format("the {} is in collision: {}{}", which, Describe(touches),
                                    Wanted(touches, options_.clearance)));
  }

  /// @pre start and goals are free.
  [[nodiscard]] PlanOutcome Solve(const JointVector& start, std::vector<JointVector> goals,
                                  std::uint64_t seed) {
    SearchProblem problem{start, std::move(goals), Inside(limits_, options_.limit_margin),
                          options_.range, seed};
    WidenBounds(problem, start);
    for (const JointVector& goal : problem.goals) WidenBounds(problem, goal);
    std::vector<JointVector> path = DirectWay(problem);
    if (path.empty()) path = FindPath(problem, checker_);
    if (path.empty()) {
      return Fail(PlanFailureReason::kBudgetExhausted,
                  fmt::format("no path found within {} collision checks; allow more, or less "
                              "clearance than {:.1f} mm, or choose another goal",
                              options_.most_checks, options_.clearance * 1e3));
    }
    found_length_ = Length(path);
    Shorten(path, checker_, seed, {options_.shortcuts, options_.most_checks / kKeptPart});
    path_length_ = Length(path);
    TimedPath timed = AtCappedSpeed(TimePath(path, options_.pace, limits_, checker_));
    PlanStatistics statistics = Statistics();
    statistics.waypoints = timed.waypoints.size();
    statistics.duration = timed.trajectory.duration();
    return Plan{std::move(timed.trajectory), std::move(timed.waypoints), statistics};
  }

 private:
  [[nodiscard]] PlanStatistics Statistics() const {
    return {.checks = world_.checks() - first_check_,
            .wall = clock_.Now() - begin_,
            .found_length = found_length_,
            .path_length = path_length_};
  }

  /// Includes start and goals in the search space, even close to a limit.
  static void WidenBounds(SearchProblem& problem, const JointVector& q) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      problem.bounds.low[i] = std::min(problem.bounds.low[i], q[i]);
      problem.bounds.high[i] = std::max(problem.bounds.high[i], q[i]);
    }
  }

  /// The same path, slower where the end effector would be faster than the world's caps.
  [[nodiscard]] TimedPath AtCappedSpeed(TimedPath path) const {
    const model::LabLimits& caps = world_.limits();
    if (!caps.v_max && !caps.w_max) return path;
    double load = 0;
    for (Duration t{}; t <= path.trajectory.duration(); t += kCycle) {
      const auto target = path.trajectory.Sample(t);
      const Vector6 twist = model::ArmModel::Panda().Twist(model::Frame::kEndEffector, target.q,
                                                           target.dq, world_.limited_arm().F_T_EE);
      if (caps.v_max) load = std::max(load, HalfNorm(twist, 0) / *caps.v_max);
      if (caps.w_max) load = std::max(load, HalfNorm(twist, 3) / *caps.w_max);
    }
    if (load <= 1) return path;
    constexpr double kBelow = 1.001;  // between the samples
    for (reference::Waypoint& point : path.waypoints) {
      point.at = FromSeconds(ToSeconds(point.at.value()) * load * kBelow);
    }
    return {reference::Trajectory(path.waypoints, {}, limits_), path.waypoints};
  }

  /// The straight segment to the first goal with a free one; often sufficient.
  [[nodiscard]] std::vector<JointVector> DirectWay(const SearchProblem& problem) {
    for (const JointVector& goal : problem.goals) {
      if (checker_.IsFree(problem.start, goal)) return {problem.start, goal};
    }
    return {};
  }

  CollisionWorld& world_;
  const JointLimits& limits_;
  const Clock& clock_;
  const PlannerOptions& options_;
  Time begin_;
  std::uint64_t first_check_;
  MotionChecker checker_;
  double found_length_ = 0;
  double path_length_ = 0;
};

void RequireInside(const char* which, const JointVector& q, const JointLimits& limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("planning: joint {} of the {}", i + 1, which), q[i],
                   limits.q_min[i] + reference::kPositionMargin,
                   limits.q_max[i] - reference::kPositionMargin);
  }
}

}  // namespace

void PlannerOptions::Validate() const {
  RequireInRange("planning: most_checks", static_cast<double>(most_checks), 1, 1e12);
  RequireInRange("planning: clearance", clearance, 0.001, 0.1);
  RequireInRange("planning: limit_margin", limit_margin, reference::kPositionMargin, 0.3);
  RequireInRange("planning: range", range, 0.01, 100);
  RequireInRange("planning: shortcuts", shortcuts, 0, 1e6);
  RequireInRange("planning: pace: velocity share", pace.velocity_scale, 1e-3, 1);
  RequireInRange("planning: pace: acceleration share", pace.acceleration_scale, 1e-3, 1);
  RequireInRange("planning: pace: jerk share", pace.jerk_scale, 1e-3, 1);
  if (pace.duration) {
    throw InputError("planning: pace: a duration cannot be asked for; give shares of the limits");
  }
}

Planner::Planner(CollisionWorld& world, const JointLimits& limits, const Clock& clock,
                 const PlannerOptions& options)
    : world_(world), limits_(limits), clock_(clock), options_(options) {
  options_.Validate();
  world.limits().Lower(limits_);
}

PlanOutcome Planner::ToConfiguration(const JointVector& start, const JointVector& goal,
                                     std::uint64_t seed) {
  RequireInside("start", start, limits_);
  RequireInside("goal", goal, limits_);
  if (Coincide(start, goal)) {
    throw InputError("planning: start and goal coincide; there is nothing to plan");
  }
  Attempt attempt(world_, limits_, clock_, options_);
  if (auto failure = attempt.Obstructed(start, "start", PlanFailureReason::kStartInCollision)) {
    return *std::move(failure);
  }
  if (auto failure = attempt.Obstructed(goal, "goal", PlanFailureReason::kGoalInCollision)) {
    return *std::move(failure);
  }
  return attempt.Solve(start, {goal}, seed);
}

PlanOutcome Planner::ToPose(const JointVector& start, const Transform& O_T_F, std::uint64_t seed) {
  RequireInside("start", start, limits_);
  Attempt attempt(world_, limits_, clock_, options_);
  if (auto failure = attempt.Obstructed(start, "start", PlanFailureReason::kStartInCollision)) {
    return *std::move(failure);
  }
  auto found = ConfigurationsAt(O_T_F, limits_, world_,
                                {.near = start,
                                 .clearance = options_.clearance,
                                 .limit_margin = options_.limit_margin,
                                 .most_checks = options_.most_checks});
  if (const auto* none = std::get_if<NoPose>(&found)) {
    return attempt.Fail(none->reason == NoPoseReason::kCollision
                            ? PlanFailureReason::kGoalInCollision
                            : PlanFailureReason::kGoalUnreachable,
                        "the goal: " + none->text);
  }
  auto& goals = std::get<std::vector<JointVector>>(found);
  if (Coincide(start, goals.front())) {
    throw InputError("planning: the flange is at the goal already; there is nothing to plan");
  }
  return attempt.Solve(start, std::move(goals), seed);
}

}  // namespace twin::planning
