#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What the correction lambda of the reference generator does: how fast an offset goes, what a
/// source that stops leads to, and both for poses.
[[nodiscard]] Findings RunLambda(const Setting& setting);

}  // namespace twin::experiment
