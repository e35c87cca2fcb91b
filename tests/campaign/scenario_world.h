#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "campaign/trial.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/cell.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// A world that is a scenario, of one robot or of several.
using ScenarioWorld = std::variant<scenario::Scenario, scenario::Cell>;

/// What its robots have in common; of one robot, all of it.
[[nodiscard]] scenario::Scenario& CommonOf(ScenarioWorld& world);

/// As a scenario file.
[[nodiscard]] std::string TextOf(const ScenarioWorld& world);

/// As RunWorld or RunCell.
[[nodiscard]] Outcome RunScenario(const ScenarioWorld& world, const run::Catalogue& catalogue,
                                  const run::RunFiles& files, bool repeats);

/// A shrunk world.
struct Shrunk {
  std::string text;                ///< a scenario file
  std::optional<Finding> finding;  ///< its own; nullopt: run once more, it violates nothing
};

/// What still violates the same invariant, as Shrink.
[[nodiscard]] Shrunk ShrinkScenario(const ScenarioWorld& world, const Finding& finding,
                                    const run::Catalogue& catalogue, const run::RunFiles& files);

/// Runs scenarios of files, one after the other, as worlds with all their repeats, and prints what
/// comes of each.
///
/// @param paths  of one robot or of several, in lockstep.
/// @returns whether none violates an invariant.
/// @throws InputError for a scenario that cannot run so: then what is printed is not of all.
[[nodiscard]] bool CheckFiles(std::span<const std::filesystem::path> paths,
                              const run::Catalogue& catalogue, const run::RunFiles& files);

}  // namespace twin::campaign
