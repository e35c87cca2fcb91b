#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The paper's Table 1 in lockstep: d_EXT and unserved cycles of the bare, the synchronous and the
/// asynchronous loop, the distribution of their read-to-read intervals, and what the share of
/// unserved cycles of the synchronous one hangs on.
[[nodiscard]] Findings RunTimings(const Setting& setting);
/// As Experiment::run_on_wall_clock.
[[nodiscard]] Findings RunTimingsOnWallClock(const Setting& setting);

}  // namespace twin::experiment
