#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "campaign/watch.h"
#include "twin/application/partners.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// What a world's seed decided.
struct Chance {
  std::uint64_t lost = 0;        ///< messages
  std::uint64_t lost_hash = 0;   ///< which
  std::uint64_t costs = 0;       ///< drawn, each another than the one before
  std::uint64_t costs_hash = 0;  ///< how long they took
  LossTally losses;
};

/// What came of a world.
struct Outcome {
  std::optional<Finding> finding;  ///< the first violation
  std::string refusal;             ///< why it was no run; empty: it was
  std::string end;                 ///< "success", "aborted: ...", ...
  std::string failure;             ///< of an application; empty: its task succeeded
  std::uint64_t cycles = 0;
  std::uint64_t states_hash = 0;
  std::vector<JointVector> path;  ///< q, measured in each cycle; only of RunOnce()
  Chance chance;
};

/// Runs a world once, watched.
///
/// Threads: any; runs share nothing but files.cache.
///
/// @param may_touch  others stand so near that they may push the arm.
/// @param partners  of an application, as application::ApplicationRun's.
[[nodiscard]] Outcome RunOnce(const scenario::Scenario& world, const run::Catalogue& catalogue,
                              const run::RunFiles& files, bool may_touch = false,
                              const application::Partners* partners = nullptr);

/// The same, and then what must not change its states: its text read back, and run without a watch;
/// the same text again with a log and a page's feed; and what must: another seed.
/// @param repeats  false: only once.
[[nodiscard]] Outcome RunWorld(const scenario::Scenario& world, const run::Catalogue& catalogue,
                               const run::RunFiles& files, bool repeats);

}  // namespace twin::campaign
