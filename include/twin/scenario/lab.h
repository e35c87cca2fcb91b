#pragma once

#include <filesystem>
#include <string_view>

#include "twin/scenario/scenario.h"

// A laboratory: properties of a site (plant, link, workstation) that replace those of a scenario. A
// method that is tuned at neither of two labs must work at both.
namespace twin::scenario {

/// @param lab     a name, of a file in the folder `labs` of the models, or a file's path.
/// @param models  DataDirectory::models. @throws InputError listing the names there are.
[[nodiscard]] std::filesystem::path FindLab(std::string_view lab,
                                            const std::filesystem::path& models);

/// Applies a lab to a scenario: keys of the lab replace those of the scenario. A lab is a YAML file
/// with these keys and no others:
///   description           for people
///   plant, link           as in scenarios
///   controller            of it wake_delay and cost: how fast the site's workstation is
/// @throws InputError "<file>:<line>: <key>: ..." for anything invalid, and for a scenario that
/// contradicts the lab.
void ApplyLab(const std::filesystem::path& file, Scenario& scenario);

}  // namespace twin::scenario
