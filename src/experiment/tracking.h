#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The paper's figure of position control: one trajectory by the synchronous loop with the client
/// library's low-pass, by the asynchronous loop with the reference generator, and by the latter
/// with the low-pass; what the joints really do, and its power spectral density.
[[nodiscard]] Findings RunTracking(const Setting& setting);
/// As Experiment::run_on_wall_clock: one run of each.
[[nodiscard]] Findings RunTrackingOnWallClock(const Setting& setting);

}  // namespace twin::experiment
