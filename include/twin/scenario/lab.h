#pragma once

#include <filesystem>
#include <string_view>

#include "twin/scenario/scenario.h"

// A laboratory: what a site makes of a scenario, and no scenario says. The same scenarios on two of
// them are what a method must bear that is tuned on neither.
namespace twin::scenario {

/// @param lab     a name, of a file in the folder `labs` of the models, or a file's path.
/// @param models  DataDirectory::models. @throws InputError listing the names there are.
[[nodiscard]] std::filesystem::path FindLab(std::string_view lab,
                                            const std::filesystem::path& models);

/// Lays a lab over a scenario: where both say something, the lab wins; what the lab does not say
/// stays. A lab is a YAML file with these keys and no others:
///   description           for people
///   plant, link           as in scenarios
///   controller            of it wake_delay and cost: how fast the site's workstation is
/// @throws InputError "<file>:<line>: <key>: ..." for anything that is not as it should be, and
/// when lab and scenario do not go together.
void ApplyLab(const std::filesystem::path& file, Scenario& scenario);

}  // namespace twin::scenario
