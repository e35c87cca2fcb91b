#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/application/application.h"

// One run of an application for its statistics.
namespace twin::application {

/// The result of one seed.
struct SeedOutcome {
  std::uint64_t seed = 0;
  std::string failure{};      ///< as FailureOf(), or the text of the exception that the run threw
  std::string failed_step{};  ///< empty: all steps succeeded
  int repeated = 0;           ///< failed attempts that were repeated
  std::vector<Finding> findings{};
  Duration duration{};  ///< robot's time
  run::CycleCounts counts{};
  std::uint64_t states_hash = 0;

  [[nodiscard]] bool succeeded() const noexcept { return failure.empty(); }
};

/// Carries the scenario's application out once, with a watch for contacts and without a log.
///
/// Threads: any; runs share nothing but files.cache. @param interrupted  set from a signal handler;
/// may be null. An outcome of an interrupted run is not complete.
/// @throws as ApplicationRun.
[[nodiscard]] SeedOutcome RunSeed(scenario::Scenario scenario, std::uint64_t seed,
                                  const run::Catalogue& catalogue, const run::RunFiles& files,
                                  const volatile bool* interrupted);

}  // namespace twin::application
