#pragma once

#include <array>
#include <vector>

#include "experiment/loop_sample.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The runs of LF, RS, RA: as many of each.
using LoopRuns = std::array<std::vector<LoopSample>, 3>;

/// Drives each of the calibrated loops through its motion Setting::seeds times, one loop after the
/// other, with seeds and start phases of their own (the bare loop has no phase).
/// @param stack  with what RS and RA run; LF has the setting's own. @param share  of the work, for
/// the progress.
/// @throws as RunScenario; InputError when a run wrote no command at all.
[[nodiscard]] LoopRuns RunLoops(const Setting& setting, const scenario::Catalogue& stack,
                                double share);

}  // namespace twin::experiment
