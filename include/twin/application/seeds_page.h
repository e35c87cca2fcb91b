#pragma once

#include <string>
#include <utility>
#include <vector>

#include "twin/application/monte_carlo.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// The page of many seeds: how many succeeded, what was found over all of them, which failed and
/// why, a histogram of each finding with a demand. One HTML file with everything in it.
/// @param facts  "lab": "a"; as a table. @throws EnvironmentError as report::DrawPlot.
[[nodiscard]] std::string SeedsPage(const scenario::Scenario& scenario,
                                    const MonteCarloResult& result,
                                    const std::vector<std::pair<std::string, std::string>>& facts);

/// A line for each seed: seed, outcome, step, failure, duration, states hash, and each finding that
/// any of them has. RFC 4180, with a header.
[[nodiscard]] std::string SeedsCsv(const MonteCarloResult& result);

}  // namespace twin::application
