#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/planning/collision_world.h"
#include "twin/planning/planner.h"
#include "twin/run/session.h"

namespace twin::run {

/// Plans from where a session's arm stands to `goal` (rad), around the scene as it is now: its free
/// bodies are brought to where they lie, the fingers to where they are, and a body that the hand
/// holds goes with it.
/// @param world  of the session's scenario (MakeWorld), without a mobile base.
/// @param seed  of the search. Threads: the session's. No time passes.
/// @throws InputError when start or goal touches something (names the bodies) or is beyond a joint
/// limit, and as Session::Peek(); NoPlanError when no path was found within the budget.
[[nodiscard]] planning::Plan PlanTo(const Session& session, planning::CollisionWorld& world,
                                    const JointVector& goal, std::uint64_t seed,
                                    const planning::PlannerOptions& options = {});

}  // namespace twin::run
