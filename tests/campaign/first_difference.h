#pragma once

#include <string>

#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// Runs a world, which has repeated itself with other states, twice more.
/// @returns in words, the first state and value that differ.
[[nodiscard]] std::string FirstDifference(const scenario::Scenario& world,
                                          const run::Catalogue& catalogue,
                                          const run::RunFiles& files);

}  // namespace twin::campaign
