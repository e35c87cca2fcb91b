#pragma once

#include <cstdint>
#include <optional>

#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// A world of the campaign: a whole scenario, drawn from one number. Robot, load, plant, links,
/// clocks, loop, chain, controller, motion, pushes, panel and hand are drawn each by itself, so
/// that rare things meet. Same seed, same world.
///
/// Most worlds can be run; a few are refused as a user's scenario would be (a motion too fast for
/// what its link allows is not refused: it must fail as the specification says).
///
/// @param around  null: everything is drawn. Else a user's scenario, of which robot, motion, tick,
/// controller type and its parameters stay, and only what surrounds them is drawn: link, clocks,
/// computation times, plant, noise, load, pushes.
[[nodiscard]] scenario::Scenario DrawWorld(std::uint64_t seed,
                                           const scenario::Scenario* around = nullptr);

}  // namespace twin::campaign
