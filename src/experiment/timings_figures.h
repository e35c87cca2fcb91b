#pragma once

#include <vector>

#include "experiment/loop_runs.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// How d_EXT is distributed, all runs of a loop together.
[[nodiscard]] Figure LatencyFigure(const LoopRuns& runs);

/// How the intervals between two reads are, normalised by the number of measurements.
[[nodiscard]] Figure IntervalFigure(const LoopRuns& runs);

/// How the unserved shares of all three hang on the weight and the place of the link's late bin,
/// the last one. Runs them for that, with few seeds. @param setting  its link's law must be a
/// histogram, as ours is. Progress from `from` to `to`.
[[nodiscard]] Figure LateStatesFigure(const Setting& setting, double from, double to);

/// What the unserved share of the synchronous loop hangs on: drift, start phase, load. Runs it for
/// that, with few seeds. Progress from `from` to 1.
[[nodiscard]] Figure SensitivityFigure(const Setting& setting, double from);

/// `key`'s values of all runs, one after the other.
[[nodiscard]] std::vector<double> Pooled(const std::vector<LoopSample>& runs,
                                         std::vector<double> LoopSample::*key);

}  // namespace twin::experiment
