#pragma once

#include <cstdint>
#include <string>

#include "campaign/trial.h"

namespace twin::campaign {

/// Whether the world of this seed is one of clients of a served robot, instead of a scenario: one
/// of sixteen, and those of goal_world.h.
[[nodiscard]] bool IsClientWorld(std::uint64_t seed);

/// Runs it: a session world (session_world.h), goals of an FR3 (goal_world.h), or a command stream
/// of tests/conformance, sound or hostile, once in process, watched by the second implementation,
/// and once over the wire. What the motion shows must be the same to the bit.
///
/// Threads: any.
[[nodiscard]] Outcome RunClientWorld(std::uint64_t seed, const run::Catalogue& catalogue,
                                     const run::RunFiles& files);

/// For people: what its clients do.
[[nodiscard]] std::string DescribeClientWorld(std::uint64_t seed);

/// The smallest stream found that still violates the same invariant, for people.
[[nodiscard]] std::string ShrinkClientWorld(std::uint64_t seed, std::string_view invariant);

}  // namespace twin::campaign
