#pragma once

#include <cstdint>
#include <optional>

#include "planning/engine_view.h"
#include "planning/planning_fixture.h"
#include "twin/model/self_collision.h"
#include "twin/onboard/measured_monitor.h"
#include "twin/planning/planner.h"
#include "twin/planning/random_goal.h"

namespace twin::planning {

/// A start and a goal, both free.
struct Problem {
  JointVector start{};
  JointVector goal{};
};

/// The n-th random problem of a world.
inline Problem ProblemOf(CollisionWorld& world, std::uint64_t n) {
  const JointVector start = RandomGoal(world, test::PandaLimits(), 2 * n);
  return {start, RandomGoal(world, test::PandaLimits(), 2 * n + 1, {.from = start})};
}

/// The first millisecond at which the arm, moved along a trajectory, touches anything by the engine
/// itself, or comes so near to itself that the robot would stop it. @param width  of the hand.
inline std::optional<Duration> FirstContact(EngineView& engine,
                                            const reference::Trajectory& trajectory, double width) {
  for (Duration t{};; t += kCycle) {
    const JointVector q = trajectory.Sample(t).q;
    engine.Set(q, width);
    if (!engine.RobotContacts().empty()) return t;
    if (model::SelfDistance(q, true) < onboard::MeasuredBounds{}.clearance_m) return t;
    if (t >= trajectory.duration()) return std::nullopt;
  }
}

}  // namespace twin::planning
