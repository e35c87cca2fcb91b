#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "experiment/loop_sample.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The runs of LF, RS, RA: as many of each.
using LoopRuns = std::array<std::vector<LoopSample>, 3>;

/// The scenario of one of CalibratedLoops() for its `run`-th run: seed and start phase of its own.
/// @throws InputError as LoadScenario.
[[nodiscard]] scenario::Scenario LoopScenario(const Setting& setting, std::size_t loop, int run);

/// Drives each of the calibrated loops through its motion Setting::seeds times, one loop after the
/// other, as LoopScenario has it (the bare loop has no phase).
/// @param stack  with what RS and RA run; LF has the setting's own. @param share  of the work, for
/// the progress.
/// @throws as RunScenario; InputError when a run wrote no command at all.
[[nodiscard]] LoopRuns RunLoops(const Setting& setting, const run::Catalogue& stack, double share);

}  // namespace twin::experiment
