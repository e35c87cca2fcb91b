#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "campaign/trial.h"
#include "twin/scenario/cell.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// A world that is a scenario, of one robot or of several.
using ScenarioWorld = std::variant<scenario::Scenario, scenario::Cell>;

/// What its robots have in common; of one robot, all of it.
[[nodiscard]] scenario::Scenario& CommonOf(ScenarioWorld& world);

/// As a scenario file.
[[nodiscard]] std::string TextOf(const ScenarioWorld& world);

/// Runs a world. @param name  for messages.
using RunScenario = std::function<Outcome(const ScenarioWorld& world, const std::string& name)>;

/// A shrunk world.
struct Shrunk {
  std::string text;                ///< a scenario file
  std::optional<Finding> finding;  ///< its own; nullopt: run once more, it violates nothing
};

/// The fewest keys that still violate the invariant, as Shrink.
[[nodiscard]] Shrunk ShrinkScenario(const ScenarioWorld& world, std::string_view invariant,
                                    const RunScenario& run);

/// What came of scenario files.
struct FileCounts {
  std::size_t violating = 0;  ///< an invariant
  std::size_t refused = 0;    ///< as they run
};

/// Prints a violation, at once. @param world  its name. Threads: any.
void Tell(const std::string& world, const Finding& finding);

/// Runs scenarios of files, one after the other, and prints what comes of each.
///
/// @param paths  of one robot or of several, in lockstep.
/// @throws InputError, before any runs, for a file that is no such scenario.
[[nodiscard]] FileCounts CheckFiles(std::span<const std::filesystem::path> paths,
                                    const RunScenario& run);

}  // namespace twin::campaign
