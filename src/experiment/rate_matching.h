#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The paper's figure of rate matching: a slow source without and with the moving average; the
/// riser of its updates and the delay the stage costs, at several rates and on three interfaces.
[[nodiscard]] Findings RunRateMatching(const Setting& setting);
/// As Experiment::run_on_wall_clock: the paper's source only.
[[nodiscard]] Findings RunRateMatchingOnWallClock(const Setting& setting);

}  // namespace twin::experiment
