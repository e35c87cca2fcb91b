#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "application/monte_carlo.h"
#include "application/performance.h"

namespace twin::application::test {

/// RunSeeds() with what the program has, on primitive shapes.
inline MonteCarloResult Seeds(const scenario::Scenario& scenario, const SeedsOptions& options,
                              const std::function<void(const SeedOutcome&)>& told = {}) {
  backend::Registry backends;
  control::ControllerRegistry controllers;
  plugins::RegisterMujoco(backends);
  controllers::RegisterControllers(controllers);
  return RunSeeds(scenario, {backends, controllers},
                  {.models = Models(), .mesh_package = {}, .cache = {}}, options, told);
}

/// Tells what came of it, for the record of the test.
inline MonteCarloResult Draw(scenario::Scenario scenario, const std::string& what,
                             int seeds = 100) {
  scenario.seed = 1;
  MonteCarloResult result = Seeds(scenario, {.seeds = seeds, .threads = 2});
  std::string text =
      fmt::format("{}: {} of {} succeeded ({:.1f} to {:.1f} %)\n", what, result.succeeded,
                  result.outcomes.size(), result.least_share * 100, result.most_share * 100);
  for (const SeedOutcome& outcome : result.outcomes) {
    if (!outcome.succeeded()) text += fmt::format("  seed {}: {}\n", outcome.seed, outcome.failure);
  }
  for (const FindingSpread& spread : result.Spreads()) {
    text += fmt::format("  {}: {:.4g} (median), {:.4g} (most, seed {}) {}\n", spread.quantity,
                        spread.median, spread.largest, spread.largest_seed, spread.unit);
  }
  std::fputs(text.c_str(), stdout);
  return result;
}

}  // namespace twin::application::test
