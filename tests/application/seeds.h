#pragma once

#include <functional>

#include "application/performance.h"
#include "twin/application/monte_carlo.h"

namespace twin::application::test {

/// RunSeeds() with what the program has, on primitive shapes.
inline MonteCarloResult Seeds(const scenario::Scenario& scenario, const MonteCarloOptions& options,
                              const std::function<void(const SeedOutcome&)>& told = {}) {
  backend::Registry backends;
  control::ControllerRegistry controllers;
  plugins::RegisterMujoco(backends);
  controllers::RegisterControllers(controllers);
  const MonotonicClock clock;
  return RunSeeds(scenario, {backends, controllers},
                  {.models = Models(), .mesh_package = {}, .cache = {}}, clock, options, told);
}

}  // namespace twin::application::test
