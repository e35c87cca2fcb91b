#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

// Experiment::run of each of Experiments(), where their titles are, and their run_on_wall_clock.

[[nodiscard]] Findings RunTimings(const Config& config);
[[nodiscard]] Findings RunTimingsOnWallClock(const Config& config);
[[nodiscard]] Findings RunJitter(const Config& config);
[[nodiscard]] Findings RunJitterOnWallClock(const Config& config);
[[nodiscard]] Findings RunNoise(const Config& config);
[[nodiscard]] Findings RunFeedForwardStudy(const Config& config);
[[nodiscard]] Findings RunTracking(const Config& config);
[[nodiscard]] Findings RunTrackingOnWallClock(const Config& config);
[[nodiscard]] Findings RunRateMatching(const Config& config);
[[nodiscard]] Findings RunRateMatchingOnWallClock(const Config& config);
[[nodiscard]] Findings RunLambda(const Config& config);
[[nodiscard]] Findings RunLosses(const Config& config);
[[nodiscard]] Findings RunViability(const Config& config);

}  // namespace twin::experiment
