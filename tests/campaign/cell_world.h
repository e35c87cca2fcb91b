#pragma once

#include <cstdint>
#include <filesystem>

#include "campaign/trial.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/cell.h"

namespace twin::campaign {

/// Whether the world of this seed is of several robots: one of 64.
[[nodiscard]] bool IsCellWorld(std::uint64_t seed);

/// That world: two or three robots in one scene, each with what any world has (DrawWorld) but a
/// mobile base, objects and a tilted floor. In half of these worlds they stand so close that they
/// may touch; in the others so far apart that they cannot, though they share a model. One of eight
/// is of two that hand a beam over, as the program's cell does, with other links and clocks.
/// @param models  the folder of models.
[[nodiscard]] scenario::Cell DrawCellWorld(std::uint64_t seed, const std::filesystem::path& models);

/// Runs a cell from its text, as `panda-twin run` does, and watches each robot as RunOnce does.
/// @param repeats  then also again, which must give the same states, and, where none can touch
/// another, each robot alone, which must move as it did beside the others.
/// @returns findings and refusals that begin with the robot's name; cycles of all robots.
[[nodiscard]] Outcome RunCell(const scenario::Cell& cell, const run::Catalogue& catalogue,
                              const run::RunFiles& files, bool repeats);

}  // namespace twin::campaign
