#pragma once

#include <vector>

#include "experiment/motion_tally.h"
#include "twin/experiment/findings.h"

namespace twin::experiment {

/// How d_EXT on the wire is distributed. @param latencies_us  rising.
[[nodiscard]] Figure ClientLatencyFigure(const std::vector<double>& latencies_us);

/// Unserved cycles in a row over the motions' time, against the 20 that end one.
[[nodiscard]] Figure ClientLossesFigure(const MotionTally& tally);

}  // namespace twin::experiment
