#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What sampling a planned trajectory at jittered instants does: the jerk INT reconstructs against
/// the paper's formulas, how often it aborts behind each remedy, and where the reference
/// generator's promise ends.
[[nodiscard]] Findings RunJitter(const Setting& setting);
/// As Experiment::run_on_wall_clock: raw stream and reference generator at this machine's jitter.
[[nodiscard]] Findings RunJitterOnWallClock(const Setting& setting);

}  // namespace twin::experiment
