#pragma once

#include <cstdint>

#include "campaign/trial.h"

namespace twin::campaign {

/// Whether the world of this seed is a client's that moves a robot to goals.
[[nodiscard]] bool IsGoalWorld(std::uint64_t seed);

/// Asynchronous motions of an FR3 (FCI protocol 10), whose commands are goals: they come at any
/// time, answer any state of their motion, are lost, late or doubled on the link, or lie beyond a
/// joint's range; and streams of positions or velocities to such goals, a Panda's too. Of some
/// robots INT guards a lab's limits.
///
/// Threads: any.
[[nodiscard]] Outcome RunGoalWorld(std::uint64_t seed, const run::Catalogue& catalogue,
                                   const run::RunFiles& files);

}  // namespace twin::campaign
